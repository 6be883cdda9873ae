"""Node values: least squares against a dense oracle, and what they do to a vibrating nozzle."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete, lfilter

from fbfcli.motion.polyline import NEAR, Polyline, fit, fit_through

W = 2 * np.pi * 30.0
B, A, _ = cont2discrete(([W * W], [1.0, 2 * 0.1 * W, W * W]), 1e-3, method="foh")
PLANT = (np.atleast_1d(np.squeeze(B)), np.atleast_1d(np.squeeze(A)))


def hats(nodes: np.ndarray) -> np.ndarray:
    """Value of every hat function at every sample, shape (n, m)."""
    return np.column_stack([np.interp(np.arange(nodes[-1] + 1), nodes, row) for row in np.eye(len(nodes))])


def fitting(seed: int, n: int, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A random walk of n samples, some nodes, and which of them are pinned."""
    rng = np.random.default_rng(seed)
    inner = np.flatnonzero(rng.random(n - 2) < rng.random()) + 1
    nodes = np.concatenate([[0], inner, [n - 1]]).astype(np.int64)
    return np.cumsum(rng.normal(0, 1, (n, 2)), axis=0), nodes, rng.random(len(nodes)) < share


fits = st.builds(fitting, st.integers(0, 2**32 - 1), st.integers(2, 120), st.sampled_from((0.0, 0.2, 0.9)))


@given(fits)
def test_the_fit_is_the_least_squares_one_and_keeps_pinned_nodes(case):
    u, nodes, pinned = case
    values = fit(u, Polyline(nodes, pinned))
    np.testing.assert_array_equal(values[pinned], u[nodes[pinned]])
    basis = hats(nodes)
    right = u - basis[:, pinned] @ u[nodes[pinned]]
    best = np.linalg.lstsq(basis[:, ~pinned], right, rcond=None)[0]
    np.testing.assert_allclose(values[~pinned], best, rtol=0, atol=1e-8 * max(1.0, np.abs(u).max()))


@given(fits)
def test_a_curve_that_is_piecewise_linear_is_its_own_fit(case):
    u, nodes, pinned = case
    polyline = Polyline(nodes, pinned)
    exact = np.column_stack([polyline.curve(u[nodes, i]) for i in (0, 1)])
    np.testing.assert_allclose(fit(exact, polyline), u[nodes], rtol=0, atol=1e-8 * max(1.0, np.abs(u).max()))


@given(fits)
def test_the_curve_and_its_adjoint_are_those_of_the_hats(case):
    u, nodes, pinned = case
    polyline, basis = Polyline(nodes, pinned), hats(nodes)
    np.testing.assert_allclose(polyline.curve(u[nodes, 0]), basis @ u[nodes, 0], atol=1e-9)
    np.testing.assert_allclose(polyline.onto_hats(u[:, 1]), np.where(pinned, 0.0, basis.T @ u[:, 1]), atol=1e-7)


def cost(u: np.ndarray, polyline: Polyline, values: np.ndarray) -> float:
    """What `fit_through` minimises, of both axes; `NEAR` weighs the distance from the fit."""
    total = 0.0
    for axis in range(2):
        miss = u[:, axis] - polyline.curve(values[:, axis])
        moved = polyline.curve(values[:, axis] - fit(u, polyline)[:, axis])
        total += float(np.square(lfilter(*PLANT, miss)).sum() + NEAR * np.square(moved).sum())
    return total


@given(fits)
def test_fitting_through_the_plant_is_never_worse_for_the_nozzle(case):
    u, nodes, pinned = case
    polyline = Polyline(nodes, pinned)
    plain = fit(u, polyline)
    through = fit_through(plain, u, polyline, (PLANT, PLANT))
    np.testing.assert_array_equal(through[pinned], u[nodes[pinned]])
    assert cost(u, polyline, through) <= cost(u, polyline, plain) * (1 + 1e-9) + 1e-12


def test_it_comes_near_the_dense_least_squares():
    rng = np.random.default_rng(3)
    n = 400
    u = np.cumsum(np.cumsum(rng.normal(0, 1e-3, (n, 2)), axis=0), axis=0)
    nodes = np.unique(np.concatenate([[0, n - 1], rng.integers(0, n, 40)]))
    pinned = np.isin(nodes, (0, n - 1))
    polyline = Polyline(nodes, pinned)
    plain = fit(u, polyline)
    through = fit_through(plain, u, polyline, (PLANT, PLANT))
    P = hats(nodes)[:, ~pinned]
    GP = lfilter(*PLANT, P, axis=0)
    best = plain.copy()
    for axis in range(2):
        rest = lfilter(*PLANT, u[:, axis] - polyline.curve(plain[:, axis]))
        rows, right = np.vstack([GP, np.sqrt(NEAR) * P]), np.concatenate([rest, np.zeros(n)])
        best[~pinned, axis] += np.linalg.lstsq(rows, right, rcond=None)[0]
    gained = cost(u, polyline, plain) - cost(u, polyline, through)
    assert gained >= 0.9 * (cost(u, polyline, plain) - cost(u, polyline, best))
