"""Laws of stretches on their grid."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_moves import moves_of, paths

from fbfcli.motion.moves import E, Z
from fbfcli.motion.sample import sample
from fbfcli.motion.stretches import Rests, compensable, kinks, lay, scaled, stretch_starts, with_rests
from fbfcli.motion.timing import executed
from fbfcli.printer import Limits

DT = 1e-3
rests = st.builds(Rests, st.integers(0, 20), st.integers(0, 20), st.integers(0, 60))


@st.composite
def batches(draw: st.DrawFn):
    """Moves, which of them are compensated, and their profile."""
    moves = draw(paths(max_size=20, velocity=300.0, acceleration=3000.0))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    known = rng.random(len(moves)) < 0.8
    inside = compensable(moves, known, 100.0)
    moves = with_rests(moves, inside, bool(draw(st.booleans())))
    return moves, inside, executed(moves, "klipper")


@given(paths(), st.data())
def test_what_is_compensated_moves_in_x_or_y_from_a_known_place(moves, data):
    known = np.array(data.draw(st.lists(st.booleans(), min_size=len(moves), max_size=len(moves))))
    inside = compensable(moves, known, 5000.0)
    assert not (inside & ~known).any()
    assert not (inside & ~(moves.delta[:, :2] != 0.0).any(axis=1)).any()
    flat = (moves.delta[:, :2] != 0.0).any(axis=1) & (moves.delta[:, Z] == 0.0)
    np.testing.assert_array_equal(inside[flat], known[flat])


@pytest.mark.parametrize("z, followed", [(0.0, True), (0.001, True), (1.0, False)])
def test_steep_moves_are_left_alone(z, followed):
    limits = Limits(axis_acceleration=(np.inf, np.inf, 200.0, np.inf), axis_velocity=(np.inf, np.inf, 10.0, np.inf))
    assert compensable(moves_of([[10.0, 0, z, 1]], 50.0, limits), np.ones(1, bool), 5000.0)[0] == followed


@given(paths(), st.data())
def test_the_machine_rests_wherever_compensation_begins_or_ends(moves, data):
    inside = np.array(data.draw(st.lists(st.booleans(), min_size=len(moves), max_size=len(moves))))
    before = data.draw(st.booleans())
    rested = with_rests(moves, inside, before)
    was = np.concatenate([[before], inside[:-1]])
    np.testing.assert_array_equal(rested.stop, moves.stop | (inside != was))


@given(batches(), rests)
def test_stretches_cover_their_moves_with_a_hold_before_and_after(batch, holds):
    moves, inside, profile = batch
    grid = lay(moves, inside, profile.duration, DT, holds, None, False)
    np.testing.assert_array_equal(grid.move, np.flatnonzero(inside))
    assert len(grid.begin) == len(stretch_starts(moves, inside))
    assert grid.count == (grid.end[-1] + 1 if len(grid.end) else 0)
    np.testing.assert_array_equal(grid.begin[1:], grid.end[:-1] + 1)
    for j, (a, b) in enumerate(zip(grid.first[:-1], grid.first[1:], strict=True)):
        t0 = grid.t0[a:b]
        last = t0[-1] + profile.duration[grid.move[b - 1]] / DT
        assert t0[0] == pytest.approx(grid.begin[j] + holds.lead, abs=1e-6)
        assert last + holds.tail <= grid.end[j] + 1e-5
        assert grid.end[j] - grid.begin[j] <= max(last - t0[0] + holds.lead + holds.tail + 1, holds.shortest)
        assert grid.end[j] - grid.begin[j] >= holds.shortest
        np.testing.assert_allclose(np.diff(t0), profile.duration[grid.move[a : b - 1]] / DT, atol=1e-6)
    np.testing.assert_array_equal(grid.stretch, np.repeat(np.arange(len(grid.begin)), np.diff(grid.first)))


@given(batches(), rests, st.data())
def test_a_stretch_laid_in_two_parts_is_the_stretch(batch, holds, data):
    moves, inside, profile = batch
    moves = replace(moves, stop=np.zeros(len(moves), bool))
    inside = np.ones(len(moves), bool)
    holds = replace(holds, shortest=0)
    whole = lay(moves, inside, profile.duration, DT, holds, None, False)
    cut = data.draw(st.integers(1, len(moves)))
    if cut == len(moves):
        return
    a = lay(moves[:cut], inside[:cut], profile.duration[:cut], DT, holds, None, True)
    b = lay(moves[cut:], inside[cut:], profile.duration[cut:], DT, holds, a.phase, False)
    assert a.count + b.count == whole.count
    np.testing.assert_allclose(np.concatenate([a.t0, b.t0 + a.count]), whole.t0, atol=1e-6)
    assert -1.0 - 1e-6 <= a.phase <= 1e-6 and a.open_last and b.continued


@given(batches(), st.floats(1.0, 8.0))
def test_slower_motion_takes_the_same_path_in_more_time(batch, slow):
    moves, inside, profile = batch
    if not inside.any():
        return
    slower = scaled(profile, np.where(inside, slow, 1.0))
    np.testing.assert_allclose(slower.duration, profile.duration * np.where(inside, slow, 1.0), rtol=1e-12)
    one = moves[np.flatnonzero(inside)]
    for p, dt in ((profile[inside], DT), (slower[inside], DT * slow)):
        t0 = np.cumsum(p.duration) - p.duration
        x, _ = sample(one.start, one.delta, one.distance, p, t0, 200, dt)
        if dt == DT:
            first = x
    np.testing.assert_allclose(x, first, rtol=0, atol=1e-7)


@given(batches(), rests)
def test_kinks_are_where_e_or_z_changes_its_speed_inside_a_stretch(batch, holds):
    moves, inside, profile = batch
    grid = lay(moves, inside, profile.duration, DT, holds, None, False)
    found = set(kinks(moves, profile, grid).tolist())
    share = moves.delta / moves.distance[:, None]
    begins = set(grid.move[grid.first[:-1]].tolist())
    wanted = set()
    for k, i in enumerate(grid.move.tolist()):
        if i not in begins:
            jump = max(abs(share[i, axis] - share[grid.move[k - 1], axis]) for axis in (Z, E)) * profile.v_start[i]
            if jump > 0.2:
                wanted.add(round(grid.t0[k]))
    assert found == wanted
