"""Vector fitting: poles of a rational function that passes through a measured response (Gustavsen & Semlyen 1999).

Each step solves a linear least-squares problem, sigma H = p with sigma(s) = 1 + sum c_n / (s - a_n), and takes the
zeros of sigma for the next poles: a Sanathanan-Koerner iteration in a basis that stays well conditioned. Poles that
leave the left half plane are mirrored into it. scipy has no such fit (its AAA bounds neither order nor poles and takes
no weights), and scikit-rf's brings a microwave engineer's toolbox for these sixty lines.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lstsq, qr

STEPS = 12


def fit_poles(s: np.ndarray, H: np.ndarray, weight: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Stable poles, shape (n,), complex ones in conjugate pairs (upper first).

    s      : complex ndarray, shape (m,)   j w [rad/s]
    H      : complex ndarray, shape (m,)
    weight : ndarray, shape (m,)           1 / standard deviation
    start  : complex ndarray, shape (n,)   poles to begin with, pairs next to each other, upper first
    """
    scale = np.abs(s).max()
    poles = start / scale
    for _ in range(STEPS):
        poles = _relocated(s / scale, H, weight, poles)
    return poles * scale


def starting_poles(pairs: int, lags: int, band: tuple[float, float]) -> np.ndarray:
    """Lightly damped pairs spread evenly in logarithm over the band [Hz], lags at its upper end."""
    w = 2 * np.pi * np.geomspace(*band, pairs + 2)[1:-1]
    upper = w * (-0.02 + 1j)
    return np.concatenate(
        [np.column_stack((upper, upper.conj())).ravel(), -2 * np.pi * band[1] * (1.0 + np.arange(lags))]
    )


def _relocated(s: np.ndarray, H: np.ndarray, weight: np.ndarray, poles: np.ndarray) -> np.ndarray:
    basis = _basis(s, poles) * weight[:, None]
    columns = np.column_stack((basis, -H[:, None] * basis))
    n = len(poles)
    # orthogonal to the numerator's columns, only sigma's are left to solve for
    Q, R = qr(np.vstack((columns.real, columns.imag)), mode="economic")
    right = weight * H
    c = lstsq(R[n:, n:], (Q.T @ np.concatenate((right.real, right.imag)))[n:], check_finite=False)[0]
    A, b = _realisation(poles)
    moved = np.linalg.eigvals(A - np.outer(b, c))
    moved = np.where(moved.real > 0, -moved.conj(), moved)
    return _paired(moved)


def _basis(s: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """1/(s - a) of real poles; sum and j times difference of a pair's two, so that coefficients are real."""
    phi = 1 / (s[:, None] - poles)
    upper = np.flatnonzero(poles.imag > 0)
    phi[:, upper], phi[:, upper + 1] = (
        phi[:, upper] + phi[:, upper + 1],
        1j * (phi[:, upper] - phi[:, upper + 1]),
    )
    return phi


def _realisation(poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A, b of the real state space whose outputs are the basis functions."""
    A, b = np.diag(poles.real), np.ones(len(poles))
    for i in np.flatnonzero(poles.imag > 0):
        A[i, i + 1], A[i + 1, i] = poles[i].imag, -poles[i].imag
        b[i], b[i + 1] = 2.0, 0.0
    return A, b


def _paired(poles: np.ndarray) -> np.ndarray:
    """Pairs, upper first, then real poles; none on the axis itself."""
    poles = np.where(poles.real > -1e-9, poles - 1e-9, poles)
    upper = poles[poles.imag > 1e-12]
    upper = upper[np.argsort(upper.imag)]
    real = np.sort(poles[np.abs(poles.imag) <= 1e-12].real)
    return np.concatenate((np.column_stack((upper, upper.conj())).ravel(), real))
