"""Contour-weighted FBF: a dense solve says the same, seams do not show, limits hold, a wrong model hurts less."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from control_cases import DT, commanded, described, family, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.signal import fftconvolve, lfilter

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.basis import uniform_basis
from fbfcli.control.design import design
from fbfcli.control.limits import Box, peaks
from fbfcli.control.truncated import truncated
from fbfcli.control.windows import SplineCompensator
from fbfcli.errors import ModelError

MICRON = 1e-3


def lifted(f: np.ndarray, rows: int, columns: int, L: int) -> np.ndarray:
    """Column i is f from sample i L on."""
    matrix = np.zeros((rows + columns * L + len(f), columns))
    for i in range(columns):
        matrix[i * L : i * L + len(f), i] = f
    return matrix[:rows]


Spans = list[tuple[int, list[AxisModel]]]  # from which knot interval on the axes are what


def dense(y: np.ndarray, weight: np.ndarray, spans: Spans, L: int, wt: float, mu: np.ndarray) -> np.ndarray:
    """The command by the normal equations of J, every plant's filtered splines written out sample by sample."""
    basis = uniform_basis(5, L)
    n, end = basis.free(len(y)), y[-1] - y[0]
    S = max(-(-(len(truncated(h)) + 6 * L - 1) // L) for _, axes in spans for axis in axes for h in axis.family)
    rows, columns = (n + S) * L, n + S
    d = np.diff(y, axis=0, append=y[-1:])
    speed = np.hypot(*d.T)
    t = d / np.where(speed > 1e-6, speed, 1.0)[:, None]
    W = weight[:, None, None] * np.where((speed > 1e-6)[:, None, None],
                                         np.eye(2) + (wt - 1.0) * t[:, :, None] * t[:, None, :], np.eye(2))  # fmt: skip
    W = np.concatenate((W, np.tile(weight[-1] * np.eye(2), (rows, 1, 1))))[:rows]
    W = np.repeat(W.reshape(-1, L, 2, 2).mean(axis=1), L, axis=0)  # of whole knot intervals
    target = np.concatenate((y - y[0], np.tile(end, (rows, 1))))[:rows]
    A, r = np.zeros((2 * columns, 2 * columns)), np.zeros(2 * columns)
    for (first, axes), stop in zip(spans, [*(first for first, _ in spans[1:]), n + S], strict=True):
        here = slice(first * L, stop * L)
        F = [[lifted(np.convolve(truncated(h), basis.beta), rows, columns, L)[here] for h in axis.family]
             for axis in axes]  # fmt: skip
        mean = [np.tensordot(axis.weights, np.array(f), 1) for axis, f in zip(axes, F, strict=True)]
        for a, b in ((0, 0), (0, 1), (1, 0), (1, 1)):
            own, other = slice(a * columns, (a + 1) * columns), slice(b * columns, (b + 1) * columns)
            w = W[here, a, b][:, None]
            pairs = zip(axes[a].weights, F[a], F[a], strict=True) if a == b else [(1.0, mean[a], mean[b])]
            A[own, other] += sum(p * f.T @ (w * g) for p, f, g in pairs)
            r[own] += mean[a].T @ (W[here, a, b] * target[here, b])
    D = lifted(np.array([1.0, -2.0, 1.0]), columns + 2, columns, 1)
    A += np.kron(np.diag(mu), D.T @ D)
    free = np.concatenate((np.arange(n), columns + np.arange(n)))
    known = np.concatenate((np.repeat([0.0, end[0]], (n, S)), np.repeat([0.0, end[1]], (n, S))))
    gamma = known.copy()
    gamma[free] = np.linalg.solve(A[np.ix_(free, free)], (r - A @ known)[free])
    Phi = lifted(basis.beta, len(y), columns, L)
    return y[0] + np.column_stack((Phi @ gamma[:columns], Phi @ gamma[columns:]))


@cache
def spread_35_28() -> tuple[list[AxisModel], SplineCompensator]:
    """The usual pair of axes, known to +-15 %, and what it makes of them."""
    axes = [family(35, 0.05, 0.15, 5), family(28, 0.05, 0.15, 5)]
    return axes, design("contour", axes, DT)


@given(
    seed=st.integers(0, 10**6),
    samples=st.integers(120, 420),
    spread=st.floats(0.02, 0.25),
    members=st.integers(1, 5),
    f=st.tuples(st.floats(20, 80), st.floats(20, 80)),
    wt=st.floats(0.01, 1.0),
)
@settings(max_examples=15, deadline=None)
def test_a_dense_solve_says_the_same(seed, samples, spread, members, f, wt):
    axes = [family(each, 0.06, spread, members) for each in f]
    compensator = design("contour", axes, DT, {"wt": wt})
    L = compensator.basis.L
    y = motion(seed, samples, hold=12)
    weight = np.random.default_rng(seed).uniform(0.1, 1.0, samples)
    u = compensator.start(y[0]).push(y, weight, True)
    if samples > compensator.settle + L:
        wanted = dense(y, weight, [(0, axes)], L, wt, compensator.solver.bend)
        rest = (compensator.basis.free(samples) + 5) * L
        assert_allclose(u[:rest], wanted[:rest], atol=1e-9)
    assert_array_equal(u[[0, -1]], y[[0, -1]])


@pytest.mark.parametrize("f", [(35.0, 28.0), (70.0, 56.0)])
def test_stitched_windows_are_as_one(f):
    axes = [family(each, 0.05, 0.15, 7) for each in f]
    stitched = design("contour", axes, DT)
    one = design("contour", axes, DT, {"n_C": 10**6, "n_up": 1})
    y = motion(3, 3 * stitched.n_up * stitched.basis.L)
    assert np.abs(commanded(stitched, y) - commanded(one, y)).max() < 0.01 * MICRON


@given(
    seed=st.integers(0, 10**6),
    samples=st.integers(1, 2500),
    pieces=st.lists(st.integers(1, 900), min_size=1, max_size=6),
)
@settings(max_examples=25, deadline=None)
def test_pieces_of_any_size_give_the_same(seed, samples, pieces):
    compensator = design("contour", *described("hictop", "28 Hz"), {"n_up": 60, "n_C": 90})
    y = motion(seed, samples)
    whole = commanded(compensator, y)
    assert_allclose(commanded(compensator, y, pieces), whole, atol=1e-9)
    assert_array_equal(whole[[0, -1]], y[[0, -1]])


@given(angle=st.floats(0, 6.3), speed=st.floats(5, 300))
@settings(max_examples=8, deadline=None)
def test_a_straight_line_at_constant_speed_survives(angle, speed):
    """The mean plant's answer to the command lies on the line, however little the error along it counts."""
    axes, compensator = spread_35_28()
    n = 4000
    s = np.interp(np.arange(n), [0, 150, n - 150, n], [0, 0, n - 300, n - 300]) * speed * DT
    line = np.array([np.cos(angle), np.sin(angle)])
    u = commanded(compensator, s[:, None] * line)
    answer = np.column_stack([np.mean([fftconvolve(u[:, k], h)[: len(u)] for h in axis.family], axis=0)
                              for k, axis in enumerate(axes)])  # fmt: skip
    assert np.abs(answer[2000:2500] @ [-line[1], line[0]]).max() < 0.01 * MICRON


@given(seed=st.integers(0, 10**6), share=st.floats(0.75, 1.5), slow=st.floats(0.9, 1.2))
@settings(max_examples=15, deadline=None)
def test_limits_hold(seed, share, slow):
    """However much less than the desired motion's own: |u''| and |u'| stay within 2 %, where there is a way at all."""
    y = motion(seed, 1500, hold=40)
    v, a = (each.max(axis=0) for each in peaks(y, np.zeros(1, dtype=int), DT))
    box = Box(np.full(2, -1e9), np.full(2, 1e9), slow * v, share * a)
    kept = design("contour", *described("35 Hz", "28 Hz"), {"rho": 0.01}, box)
    speed, acceleration = peaks(commanded(kept, y), np.zeros(1, dtype=int), DT)
    assert (acceleration <= 1.02 * box.acceleration).all()
    assert (speed <= 1.02 * np.maximum(box.velocity, v)).all()


def test_limits_that_are_far_away_change_nothing():
    y = motion(6, 1500, hold=40)
    box = Box(np.full(2, -1e9), np.full(2, 1e9), np.full(2, 2000.0), np.full(2, 1e5))
    free, kept = (design("contour", *described("35 Hz", "28 Hz"), None, each) for each in (None, box))
    assert_array_equal(commanded(kept, y), commanded(free, y))


def test_another_design_goes_on_with_a_stretch():
    """Of a slower plant, whose splines last longer: like that design alone once the change is past."""
    first, second = (design("contour", [family(f, 0.05, 0.15, 5), family(36, 0.05, 0.15, 5)], DT,
                            {"L": 7, "n_up": 60, "n_C": 140}) for f in (45.0, 36.0))  # fmt: skip
    y = motion(5, 8000)
    stream = first.start(y[0])
    u = [stream.push(y[:3000], np.ones(3000), False)]
    u.append(second.resume(stream).push(y[3000:], np.ones(5000), True))
    command = np.concatenate(u)
    assert command.shape == y.shape
    assert_allclose(command[6000:], commanded(second, y)[6000:], atol=1e-6)
    assert_allclose(command[:2000], commanded(first, y)[:2000], atol=1e-12)


@pytest.mark.parametrize("change", [7, 160, 301])
def test_plants_that_change_within_a_window_are_solved_together(change):
    first, second = ([family(f, 0.06, 0.1, 3), family(40, 0.06, 0.1, 3)] for f in (55.0, 44.0))
    before, after = (design("contour", axes, DT, {"L": 6, "mu": 20.0}) for axes in (first, second))
    y, weight = motion(8, 420, hold=20), np.ones(420)
    stream = before.start(y[0])
    u = [stream.push(y[:change], weight[:change], False)]
    u.append(after.resume(stream).push(y[change:], weight[change:], True))
    wanted = dense(y, weight, [(0, first), (-(-change // 6), second)], 6, 0.05, before.solver.bend)
    assert_allclose(np.concatenate(u)[:400], wanted[:400], atol=1e-9)


def test_a_wrong_model_hurts_less_than_the_best_shaper_of_the_field():
    """A square at 100 mm/s, resonances 10 % off either way: normal error below MZV's and below FBF's."""
    square = corners(np.array([[0, 0], [40, 0], [40, 40], [0, 40], [0, 0]], float), 100.0, 5000.0)
    exact = [family(35, 0.05, 0.0, 1), family(28, 0.05, 0.0, 1)]
    spread = [family(35, 0.05, 0.15, 7), family(28, 0.05, 0.15, 7)]
    commands = {"mzv": design("mzv", exact, DT), "lpfbs": design("lpfbs", exact, DT),
                "contour": design("contour", spread, DT)}  # fmt: skip
    for off in (0.9, 1.1):
        real = [family(35 * off, 0.05, 0.0, 1), family(28 * off, 0.05, 0.0, 1)]
        error = {name: normal_error(commanded(one, square), square, real) for name, one in commands.items()}
        assert error["contour"] < 0.8 * min(error["mzv"], error["lpfbs"]), (off, error)


def corners(points: np.ndarray, speed: float, acceleration: float) -> np.ndarray:
    """Straight moves from rest to rest, with holds, sampled; shape (n, 2)."""
    parts = [np.tile(points[0], (60, 1))]
    for a, b in pairwise(points):
        length, ramp = np.hypot(*(b - a)), speed / acceleration
        t = np.arange(0.0, length / speed + ramp, DT)
        late = np.maximum(0.0, t - length / speed)
        s = np.where(t < ramp, 0.5 * acceleration * t**2, speed * (t - ramp / 2)) - 0.5 * acceleration * late**2
        parts.append(a + (np.minimum(s, length) / length)[:, None] * (b - a))
    return np.concatenate([*parts, np.tile(points[-1], (60, 1))])


def normal_error(u: np.ndarray, y: np.ndarray, real: list[AxisModel]) -> float:
    """RMS of the error across the path where it moves."""
    e = np.column_stack([lfilter(axis.b, axis.a, u[:, k] - u[0, k]) + u[0, k] for k, axis in enumerate(real)]) - y
    d = np.diff(y, axis=0, append=y[-1:])
    speed = np.hypot(*d.T)
    moving = speed > 1e-6
    return float(np.sqrt(np.mean(((e[:, 0] * d[:, 1] - e[:, 1] * d[:, 0])[moving] / speed[moving]) ** 2)))


def test_one_axis_alone_has_no_contour():
    with pytest.raises(ModelError, match="both"):
        design("contour", *described("35 Hz"))


def test_splines_without_acceleration_are_refused():
    with pytest.raises(ModelError, match="degree 2"):
        design("contour", *described("35 Hz", "28 Hz"), {"degree": 1})
