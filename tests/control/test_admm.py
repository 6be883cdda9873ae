"""Bounds on differences: the conditions of an optimum, and the bands that lead to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import minimize

from fbfcli.control.admm import Bounds, within
from fbfcli.control.differences import Differences, add_squares

S = 4  # half the width of the bands here
SEEDS = st.integers(0, 10**6)


def dense_of(T: np.ndarray) -> np.ndarray:
    """The symmetric matrix of a band by columns."""
    n, width = T.shape
    A = np.zeros((n, n))
    for column in range(n):
        for d in range(min(width, n - column)):
            A[column + d, column] = A[column, column + d] = T[column, d]
    return A


def differences(order: int, n: int, rng: np.random.Generator, after: bool) -> Differences:
    return Differences(order, rng.normal(size=(order, 2)), rng.normal(size=(order if after else 0, 2)))


@given(SEEDS, st.integers(1, 2), st.integers(3, 12), st.booleans())
@settings(max_examples=40, deadline=None)
def test_back_is_the_adjoint(seed, order, n, after):
    rng = np.random.default_rng(seed)
    D = differences(order, n, rng, after)
    g, still = rng.normal(size=(n, 2)), np.zeros((n, 2))
    v = rng.normal(size=D.of(g).shape)
    assert_allclose(((D.of(g) - D.of(still)) * v).sum(), (g * D.back(v)).sum(), rtol=1e-9, atol=1e-9)


@given(SEEDS, st.integers(1, 2), st.integers(3, 12), st.booleans())
@settings(max_examples=40, deadline=None)
def test_the_band_is_that_of_the_squares(seed, order, n, after):
    rng = np.random.default_rng(seed)
    D, g = differences(order, n, rng, after), rng.normal(size=(n, 2))
    c = rng.uniform(0, 1, (n + order, 2))
    if not after:
        c[n:] = 0.0
    T = np.zeros((2 * n, 2 * S))
    add_squares(T, order, c)
    moved = D.of(g) - D.of(np.zeros((n, 2)))
    x = g.reshape(-1)
    assert_allclose(x @ dense_of(T) @ x, (c[: len(moved)] * moved**2).sum(), rtol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_best_within_bounds_is_found(seed):
    """Against a general solver (sequential quadratic programming), on small problems that the bounds bite."""
    rng = np.random.default_rng(seed)
    n = 9
    T = np.zeros((2 * n, 2 * S))
    T[:, 0] = rng.uniform(1.0, 2.0, 2 * n)
    T[:, 1:3] = rng.uniform(-0.2, 0.2, (2 * n, 2))
    T[-1, 1:] = T[-2, 2:] = 0.0
    r = 3.0 * rng.normal(size=(n, 2))
    most = {1: np.array([0.8, 0.6]), 2: np.array([0.7, 0.9])}
    bounds = [Bounds(Differences(order, np.zeros((order, 2)), np.zeros((0, 2))), np.full(2, 0.5), most[order])
              for order in (1, 2)]  # fmt: skip
    A = dense_of(T)
    found = within(T, r, bounds, np.linalg.solve(A, r.reshape(-1)).reshape(n, 2))

    def cost(x):
        return 0.5 * x @ A @ x - r.reshape(-1) @ x

    def room(x):
        moved = [(bound, D.of(x.reshape(n, 2))) for D, _, bound in bounds]
        return np.concatenate([(bound - sign * each).ravel() for bound, each in moved for sign in (1, -1)])

    best = minimize(cost, np.zeros(2 * n), jac=lambda x: A @ x - r.reshape(-1), method="SLSQP",
                    constraints={"type": "ineq", "fun": room}, options={"maxiter": 500, "ftol": 1e-12})  # fmt: skip
    assert max(bound.excess(best.x.reshape(n, 2)) for bound in bounds) > 0.999  # they bite
    assert max(bound.excess(found) for bound in bounds) < 1.011
    assert cost(found.reshape(-1)) == pytest.approx(best.fun, rel=0.02)
