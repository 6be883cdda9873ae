"""Laws of the look-ahead, and Klipper's planner one move at a time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_moves import moves_of, paths
from scalar_planners import klipper_durations

from fbfcli.motion.junctions import corner_limits
from fbfcli.motion.lookahead import Plan, plan, plan_block, reach, settled
from fbfcli.motion.moves import Moves
from fbfcli.motion.profile import profile
from fbfcli.printer import FIRMWARES, Limits

EPS = 1e-9


def planned(moves: Moves, firmware: str = "klipper") -> Plan:
    return plan(corner_limits(moves, firmware), moves.distance)


def seconds(moves: Moves, firmware: str = "klipper") -> np.ndarray:
    return profile(planned(moves, firmware)).duration


@settings(deadline=None, max_examples=300)
@given(paths())
def test_klipper_agrees_with_the_move_by_move_planner(moves):
    np.testing.assert_allclose(seconds(moves), klipper_durations(moves), rtol=0, atol=EPS)


def test_klipper_agrees_over_short_segments_of_a_curve():
    angle = np.cumsum(np.random.default_rng(3).normal(0, 0.2, 3000))
    d = np.random.default_rng(4).lognormal(-1.5, 1.0, 3000)
    delta = np.stack((d * np.cos(angle), d * np.sin(angle), 0 * d, 0.03 * d), axis=1)
    moves = moves_of(delta, 180.0, Limits(acceleration=4000.0, minimum_cruise_ratio=0.5, jerk=(9, 9, 9, 1.0)))
    np.testing.assert_allclose(seconds(moves), klipper_durations(moves), rtol=0, atol=EPS)


def test_minimum_cruise_ratio_caps_the_peak_of_a_short_move():
    moves = moves_of([[1.0, 0, 0, 0]], 400.0, Limits(acceleration=1000.0, minimum_cruise_ratio=0.5))
    assert planned(moves).w_cruise[0] == pytest.approx(1000.0 * (1 - 0.5) * 1.0)


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths())
def test_limits_are_never_exceeded(firmware, moves):
    corners, p = corner_limits(moves, firmware), planned(moves, firmware)
    gain = 2 * p.accel * p.d * (1 + EPS) + EPS * corners.cruise.max()
    assert (p.w_cruise <= corners.cruise).all()
    assert (p.w_start <= corners.entry).all() and p.w_end[-1] == 0.0
    assert (p.w_start <= p.w_cruise).all() and (p.w_end <= p.w_cruise).all()
    assert (2 * p.w_cruise - p.w_start - p.w_end <= gain).all()
    np.testing.assert_array_equal(p.w_start[1:], p.w_end[:-1])


@pytest.mark.parametrize("firmware", ["marlin", "reprapfirmware"])
@settings(deadline=None)
@given(moves=paths())
def test_every_corner_is_as_fast_as_something_allows(firmware, moves):
    corners, p = corner_limits(moves, firmware), planned(moves, firmware)
    gain, slack = 2 * p.accel * p.d, EPS * corners.cruise.max()
    w = np.append(p.w_start, 0.0)
    tight = w[:-1] >= corners.entry - slack
    tight |= w[:-1] >= w[1:] + gain - slack
    tight[1:] |= w[1:-1] >= w[:-2] + gain[:-1] - slack
    assert tight.all()


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths(max_size=60), data=st.data())
def test_a_file_in_blocks_is_planned_as_in_one(firmware, moves, data):
    parts, previous, w_entry, waiting, read = [], None, 0.0, moves[:0], 0
    while read < len(moves):
        size = data.draw(st.integers(1, 25))
        waiting, read = moves[read - len(waiting):read + size], read + size
        part, n = plan_block(waiting, firmware, previous, w_entry, last=read >= len(moves))
        assert len(part) == n
        parts.append(part)
        if n:
            previous, w_entry = waiting[n - 1:n], float(part.w_end[-1])
        waiting = waiting[n:]
    whole = planned(moves, firmware)
    for name in ("w_start", "w_cruise", "w_end"):
        got, want = np.concatenate([getattr(part, name) for part in parts]), getattr(whole, name)
        np.testing.assert_allclose(got, want, rtol=EPS, atol=EPS * whole.w_cruise.max())


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths(max_size=60), data=st.data())
def test_settled_moves_do_not_change_whatever_follows(firmware, moves, data):
    k = data.draw(st.integers(1, len(moves)))
    n = settled(corner_limits(moves[:k], firmware), moves[:k].distance)
    assert n < k
    part, whole = planned(moves[:k], firmware), planned(moves, firmware)
    np.testing.assert_allclose(part.w_cruise[:n], whole.w_cruise[:n], rtol=EPS)


def test_blocks_settle_soon():
    """All but the last stopping distance of a zigzag is settled."""
    moves = moves_of([[1, 0, 0, 0], [0, 1, 0, 0]] * 500)
    assert plan_block(moves, "klipper")[1] > 990


def test_reach_keeps_its_digits_over_100000_corners():
    rng = np.random.default_rng(0)
    W = rng.uniform(0, 1e4, 100_001) * (rng.random(100_001) < 0.02) + 9e4
    W[rng.integers(0, len(W), 1000)] = rng.uniform(0, 1e2, 1000)
    D = rng.lognormal(5, 2, 100_000)
    want = W.copy()
    for i, gain in enumerate(D):
        want[i + 1] = min(want[i + 1], want[i] + gain)
    for i in range(len(D) - 1, -1, -1):
        want[i] = min(want[i], want[i + 1] + D[i])
    np.testing.assert_allclose(reach(W, D), want, rtol=EPS, atol=0)


@settings(deadline=None)
@given(paths(max_size=12, kinds=("print", "travel"), states=1, minimum_cruise_ratio=0.0))
def test_the_way_back_takes_as_long(moves):
    there = replace(moves, stop=np.zeros(len(moves), bool))
    back = replace(there, delta=there.delta[::-1] * [-1, -1, -1, 1], speed=there.speed[::-1])
    assert seconds(back).sum() == pytest.approx(seconds(there).sum(), rel=EPS)


@given(st.lists(st.floats(0.1, 30.0), min_size=1, max_size=8), st.floats(1.0, 500.0), st.floats(0.0, np.pi))
def test_a_straight_move_in_pieces_takes_as_long(pieces, speed, angle):
    limits = Limits(minimum_cruise_ratio=0.0)
    direction = np.array([np.cos(angle), np.sin(angle), 0.0, 0.0])
    whole = moves_of([sum(pieces) * direction], speed, limits)
    split = moves_of(np.outer(pieces, direction), speed, limits)
    assert seconds(split).sum() == pytest.approx(seconds(whole).sum(), rel=1e-9)
