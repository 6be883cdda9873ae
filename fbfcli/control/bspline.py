"""Clamped B-splines and rational B-splines (NURBS) on normalised time, as columns of a basis, and their derivatives.

m degree, n + 1 functions, eta knots (m zeros, then 0, 1/(n-m+1), ..., 1, then m ones), xi normalised time in [0, 1],
N[k, i] = N_{i,m}(xi_k), w weights. Knot intervals are half open, only the last point is closed: the columns sum to one.
"""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.interpolate import BSpline

from fbfcli.errors import ControlError


def normalised_time(M: int) -> np.ndarray:
    """xi_k = k / M, k = 0..M: M + 1 samples of a trajectory."""
    return np.arange(M + 1) / M


def clamped_knots(n: int, m: int) -> np.ndarray:
    """Uniform knots whose ends are repeated, shape (m + n + 2,), Ramani 2020 Eq. F.3 (Duan 2015 Eq. 24)."""
    if not 0 <= m <= n:
        raise ControlError(f"splines of degree {m} need at least {m + 1} functions, {n + 1} are asked for")
    return np.concatenate((np.zeros(m), np.linspace(0, 1, n - m + 2), np.ones(m)))


def bsplines(xi: np.ndarray, n: int, m: int, order: int = 0) -> np.ndarray:
    """The functions, or their derivatives by xi of the given order, shape (len(xi), n + 1), Ramani 2020 Eq. F.2."""
    eta = clamped_knots(n, m)
    if order > m:
        return np.zeros((len(xi), n + 1))
    inner = eta[order : len(eta) - order]  # each derivative drops the first and the last knot
    N = BSpline.design_matrix(xi, inner, m - order).toarray()
    return N @ _control_points(eta, n, m, order)


def _control_points(eta: np.ndarray, n: int, m: int, order: int) -> np.ndarray:
    """Control points of a derivative from those of the spline, shape (n + 1 - order, n + 1), Duan 2015 Eq. 32-35."""
    q = np.eye(n + 1)
    for r in range(order):
        degree, knots = m - r, eta[r : len(eta) - r]
        span = knots[degree + 1 : -1] - knots[1 : -degree - 1]  # g_{j+m+1} - g_{j+1}
        q = degree * np.diff(q, axis=0) / span[:, None]
    return q


def nurbs(xi: np.ndarray, m: int, w: np.ndarray, order: int = 0) -> np.ndarray:
    """Rational functions R_{i,m} of positive weights, or their derivatives by xi, shape (len(xi), len(w)).

    R = A / W with A = N diag(w), W = N w (Duan 2015 Eq. 26). Leibniz' rule on A = R W gives every order
        R^(r) = (A^(r) - sum_{k=1..r} binom(r, k) W^(k) R^(r-k)) / W
    whose r = 1 is Duan 2015 Eq. 28.
    """
    w = np.asarray(w, dtype=float)
    if not (w > 0).all():
        raise ControlError(f"weights of a rational spline are positive, one is {w.min():g}")
    N = [bsplines(xi, len(w) - 1, m, r) for r in range(order + 1)]
    W = [each @ w for each in N]
    R: list[np.ndarray] = []
    for r in range(order + 1):
        A = N[r] * w
        for k in range(1, r + 1):
            A = A - comb(r, k) * W[k][:, None] * R[r - k]
        R.append(A / W[0][:, None])
    return R[order]
