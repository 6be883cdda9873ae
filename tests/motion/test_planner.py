"""Planning in parts is planning."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_moves import moves_of, paths

from fbfcli.motion import planner
from fbfcli.motion.planner import LONGEST_MOVE_S, Planner, divided, joined, no_part
from fbfcli.motion.profile import Profile
from fbfcli.motion.timing import executed
from fbfcli.printer import FIRMWARES, Limits

each_firmware = pytest.mark.parametrize("firmware", FIRMWARES)


def fed(firmware: str, moves, sizes: list[int]) -> list[planner.Part]:
    """Parts of the moves, fed so many at a time (repeated)."""
    machine, parts, at, turn = Planner(firmware), [], 0, 0
    while at < len(moves):
        end = min(at + sizes[turn % len(sizes)], len(moves))
        parts += machine.feed(moves[at:end], np.arange(at, end), end == len(moves))
        at, turn = end, turn + 1
    return parts


@each_firmware
@given(paths(max_size=30), st.lists(st.integers(1, 12), min_size=1, max_size=4))
def test_parts_are_all_moves_in_order_with_the_plan_of_the_whole(firmware, moves, sizes):
    moves, _ = divided(moves, np.arange(len(moves)))
    parts = fed(firmware, moves, sizes)
    whole = executed(moves, firmware)
    np.testing.assert_array_equal(np.concatenate([part.tag for part in parts]), np.arange(len(moves)))
    np.testing.assert_array_equal(np.concatenate([part.moves.delta for part in parts]), moves.delta)
    for name in ("v_start", "v_cruise", "v_end", "duration"):
        found, wanted = np.concatenate([getattr(part.profile, name) for part in parts]), getattr(whole, name)
        power = 1 if name == "duration" else 2  # the look-ahead plans v^2, rounded at the scale of its largest
        within = 1e-9 * max(1.0, float((wanted**power).max()))
        np.testing.assert_allclose(found**power, wanted**power, rtol=1e-6, atol=within, err_msg=name)
    assert all(isinstance(part.profile, Profile) and len(part.profile) == len(part.moves) for part in parts)


@given(paths(max_size=30), st.lists(st.integers(1, 12), min_size=1, max_size=4))
def test_each_part_knows_the_move_after_it(moves, sizes):
    moves, _ = divided(moves, np.arange(len(moves)))
    parts = fed("klipper", moves, sizes)
    end = 0
    for part in parts:
        end += len(part.moves)
        if end == len(moves):
            assert part.next is None
        elif part.next is not None:
            np.testing.assert_array_equal(part.next.delta, moves.delta[end : end + 1])


@settings(max_examples=30)
@given(paths(max_size=40), st.sampled_from((0.05, 0.5)))
def test_parts_last_no_longer_than_they_may(moves, part_s):
    moves, _ = divided(moves, np.arange(len(moves)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(planner, "PART_S", part_s)
        parts = fed("klipper", moves, [len(moves)])
    whole = executed(moves, "klipper")
    np.testing.assert_allclose(np.concatenate([part.profile.duration for part in parts]), whole.duration, rtol=1e-9)
    longest = whole.duration.max()
    assert all(part.profile.duration.sum() <= part_s + 2 * longest for part in parts)


@given(paths(max_size=10), st.floats(1e-3, 1.0))
def test_slow_moves_are_divided_without_a_trace(moves, slower):
    moves = moves_of(moves.delta, 50.0, Limits(acceleration=1e7, travel_acceleration=1e7))
    slow = moves_of(moves.delta, 1e-3 + slower, moves.limits[0])
    pieces, tag = divided(slow, np.arange(len(slow)))
    assert (pieces.distance / pieces.speed <= LONGEST_MOVE_S * (1 + 1e-9)).all()
    for i in range(len(slow)):
        mine = tag == i
        np.testing.assert_allclose(pieces.delta[mine].sum(axis=0), slow.delta[i], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(pieces.start[mine][0], slow.start[i], rtol=1e-9)
    np.testing.assert_allclose(
        executed(pieces, "klipper").duration.sum(), executed(slow, "klipper").duration.sum(), rtol=1e-6
    )


@given(paths(max_size=10), st.integers(0, 10))
def test_joined_moves_are_the_moves(moves, cut):
    again = joined(moves[:cut], moves[cut:])
    np.testing.assert_array_equal(again.delta, moves.delta)
    np.testing.assert_array_equal(again.line, moves.line)
    assert again.limits == moves.limits


def test_nothing_is_planned_of_nothing():
    part = no_part((Limits(),))
    assert len(part.moves) == len(part.profile) == 0 and part.next is None
    assert list(Planner("marlin").feed(part.moves, part.tag, True)) == []
