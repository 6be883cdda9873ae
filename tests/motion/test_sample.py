"""Laws of the sampled trajectory."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_moves import moves_of, paths

from fbfcli.motion.junctions import corner_limits
from fbfcli.motion.lookahead import plan
from fbfcli.motion.profile import Profile, profile
from fbfcli.motion.sample import sample
from fbfcli.printer import Limits

DT = 1e-3


def sampled(moves, t0_first: float = 0.0, rests=0.0, dt: float = DT, extra: int = 3):
    """x, move index, profile and t0 of moves that each rest for `rests` after their end."""
    p = profile(plan(corner_limits(moves, "klipper"), moves.distance))
    t0 = t0_first + np.concatenate(([0.0], np.cumsum(p.duration + rests)))
    count = max(int(np.ceil(t0[-1] / dt)), 0) + extra
    return *sample(moves.start, moves.delta, moves.distance, p, t0[:-1], count, dt), p, t0


def position(moves, p: Profile, t0, t: float) -> np.ndarray:
    """Where the tool is at time t, one sample at a time."""
    i = max(int(np.searchsorted(t0[:-1], t, side="right")) - 1, 0)
    tau = min(max(t - t0[i], 0.0), p.duration[i])
    up, flat = min(tau, p.t_accel[i]), min(max(tau - p.t_accel[i], 0.0), p.t_cruise[i])
    down = tau - up - flat if p.t_decel[i] > 0 else 0.0  # not what rounding left over
    s = p.v_start[i] * up + p.v_cruise[i] * (flat + down)
    if up:
        s += (p.v_cruise[i] - p.v_start[i]) / p.t_accel[i] * up**2 / 2
    if down:
        s -= (p.v_cruise[i] - p.v_end[i]) / p.t_decel[i] * down**2 / 2
    return moves.start[i] + moves.delta[i] * s / moves.distance[i]


@settings(deadline=None, max_examples=60)
@given(paths(max_size=8), st.floats(-0.02, 0.02), st.sampled_from((0.0, 0.0033)))
def test_samples_are_where_the_profile_says(moves, t0_first, rests):
    dt = max(DT, np.ptp(moves.distance) / 50)
    x, index, p, t0 = sampled(moves, t0_first, rests, dt)
    for k in range(0, len(x), max(1, len(x) // 50)):
        np.testing.assert_allclose(x[k], position(moves, p, t0, k * dt), rtol=0, atol=1e-7)
    assert (np.diff(index) >= 0).all() and index.dtype == np.int32


@settings(deadline=None, max_examples=60)
@given(paths(max_size=8))
def test_the_end_is_exact_and_columns_are_contiguous(moves):
    x, index, *_ = sampled(moves)
    np.testing.assert_array_equal(x[-1], moves.start[-1] + moves.delta[-1])
    assert index[-1] == len(moves) - 1
    assert x.flags.f_contiguous


def test_an_end_on_the_grid_is_exact_there():
    moves = moves_of([[100.0, 30.0, 0, 1]], 100.0, Limits(acceleration=1000.0, minimum_cruise_ratio=0.0))
    p = profile(plan(corner_limits(moves, "klipper"), moves.distance))
    dt = float(p.duration[0]) / 700
    x, _ = sample(moves.start, moves.delta, moves.distance, p, np.zeros(1), 701, dt)
    np.testing.assert_array_equal(x[-1], moves.start[0] + moves.delta[0])


def test_the_tool_rests_before_between_and_after_moves():
    moves = moves_of([[1.0, 0, 0, 0], [0, 1.0, 0, 0]], 100.0)
    x, index, p, t0 = sampled(moves, t0_first=0.01, rests=0.02)
    assert (x[:11] == 0.0).all()
    resting = slice(int(np.ceil((t0[0] + p.duration[0]) / DT)), int(np.floor(t0[1] / DT)) + 1)
    np.testing.assert_array_equal(x[resting], np.broadcast_to(moves.start[1], x[resting].shape))
    assert (np.diff(index) >= 0).all()


@settings(deadline=None, max_examples=60)
@given(paths(max_size=10, states=1, acceleration=3000.0))
def test_no_sample_is_faster_than_its_move(moves):
    x, _, p, _ = sampled(moves)
    step = np.sqrt((np.diff(x[:, :3], axis=0) ** 2).sum(axis=1))
    assert step.max(initial=0.0) <= p.v_cruise.max() * DT * (1 + 1e-9) + 1e-12


def test_a_window_of_a_trajectory_is_the_trajectory():
    moves = moves_of([[3.0, 0, 0, 0], [0, 4.0, 0, 0], [1e-3, 0, 0, 0]], 60.0)
    x, index, p, t0 = sampled(moves)
    k = 40
    x_late, index_late = sample(moves.start, moves.delta, moves.distance, p, t0[:-1] - k * DT, len(x) - k, DT)
    np.testing.assert_allclose(x_late, x[k:], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(index_late, index[k:])


def test_no_samples_and_moves_of_no_length():
    moves = moves_of([[0.0, 0, 0, 0], [1.0, 0, 0, 0]])
    x, index, *_ = sampled(moves)
    assert np.isfinite(x).all() and index[0] == 1
    none, index = sample(moves.start, moves.delta, moves.distance, sampled(moves)[2], np.zeros(2), 0, DT)
    assert none.shape == (0, 4) and len(index) == 0
