"""Filtered basis functions in continuous time: Duan 2015 Eq. 40, by orthonormalising functions instead of vectors.

    min over gamma of  int_0^T (y_d(t) - sum_i gamma_i u~_i(t))^2 dt,      u~_i = g * u_i from rest
u_i clamped splines of degree m on normalised time t / T, plant x' = A x + B u, y = C x + D u. Between two knots a
spline is a polynomial, and the state that it drives is a matrix exponential: nothing is sampled. Integrals are
Gauss-Legendre sums on each of the spans between the knots, which are exact for the splines; the plant's own modes must
be well resolved by `points` of them per span.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from fbfcli.control.bspline import bsplines, clamped_knots
from fbfcli.control.lifted import StateSpace
from fbfcli.errors import ControlError

POINTS = 12  # per span
DEPENDENT = 1e-12  # of a function's norm: what is left of it beside the others is rounding


@dataclass(frozen=True)
class ContinuousBasis:
    """Splines and what the plant makes of them, at the nodes of the integral.

    t         : ndarray, shape (N,)          nodes [s]
    weights   : ndarray, shape (N,)          of the integral [s]
    u, y      : ndarray, shape (N, n + 1)    functions and filtered functions
    Omega     : ndarray, shape (n + 1, n + 1)   y = Psi Omega, upper triangular
    Psi       : ndarray, shape (N, n + 1)    orthonormal: int Psi_i Psi_j dt = delta_ij
    """

    t: np.ndarray
    weights: np.ndarray
    u: np.ndarray
    y: np.ndarray
    Omega: np.ndarray
    Psi: np.ndarray

    def coefficients(self, y_d: np.ndarray) -> np.ndarray:
        """gamma of Eq. 40 for a desired trajectory at the nodes: Omega gamma = int Psi y_d dt."""
        return np.linalg.solve(self.Omega, self.Psi.T @ (self.weights * y_d))

    def error(self, y_d: np.ndarray) -> float:
        """Root mean square over time of what is left."""
        left = y_d - self.Psi @ (self.Psi.T @ (self.weights * y_d))
        return float(np.sqrt(self.weights @ left**2 / self.weights.sum()))


def continuous_basis(plant: StateSpace, T: float, n: int, m: int, points: int = POINTS) -> ContinuousBasis:
    """n + 1 splines of degree m over [0, T] s behind a plant with one input and one output."""
    A, B, C, D = plant
    if B.shape[1] != 1 or len(C) != 1:
        raise ControlError(f"continuous time is for one input and one output, not {B.shape[1]} and {len(C)}")
    spans = n - m + 1
    span = T / spans
    nodes, weights = np.polynomial.legendre.leggauss(points)
    tau = span * (nodes + 1) / 2
    starts = np.unique(clamped_knots(n, m))[:-1] * T
    t = (starts[:, None] + tau).ravel()
    # d/dt [x; u; u'; ...; u^(m)] = F [...]: the input's derivatives feed each other, the last stays
    states = len(A)
    F = np.zeros((states + m + 1, states + m + 1))
    F[:states, :states], F[:states, states] = A, B[:, 0]
    F[states:-1, states + 1 :] += np.eye(m)
    flows = np.array([expm(F * each) for each in (*tau, span)])
    out = np.concatenate((C[0], D[0], np.zeros(m)))
    rows = out @ flows[:-1]  # what every node of a span sees of the state at its start
    x, y = np.zeros((states, n + 1)), []
    derivatives = np.array([bsplines(starts / T, n, m, r) / T**r for r in range(m + 1)])
    for j in range(spans):  # a span's end state is the next one's start
        begin = np.concatenate((x, derivatives[:, j]))
        y.append(rows @ begin)
        x = (flows[-1] @ begin)[:states]
    y_all = np.concatenate(y)
    w = np.tile(weights * span / 2, spans)
    Psi, Omega = gram_schmidt(y_all, w)
    return ContinuousBasis(t, w, bsplines(t / T, n, m), y_all, Omega, Psi)


def gram_schmidt(y: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Psi orthonormal under sum_k weights_k f g, Omega upper triangular, y = Psi Omega.

    Projected twice: what one projection leaves is not orthogonal to working precision.
    """
    size = y.shape[1]
    Psi, Omega = np.zeros_like(y), np.zeros((size, size))
    for i in range(size):
        left = y[:, i]
        for _ in range(2):
            part = Psi[:, :i].T @ (weights * left)
            left = left - Psi[:, :i] @ part
            Omega[:i, i] += part
        Omega[i, i] = np.sqrt(weights @ left**2)
        if Omega[i, i] <= DEPENDENT * np.sqrt(weights @ y[:, i] ** 2):
            raise ControlError(f"filtered function {i} of {size} depends on those before it: take fewer functions")
        Psi[:, i] = left / Omega[i, i]
    return Psi, Omega
