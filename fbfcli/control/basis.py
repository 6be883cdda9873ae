"""Uniform B-splines sampled every dt: beta(k - iL), i = ..., -1, 0, 1, ..., support [iL, (i + m + 1) L].

m degree, L samples between knots, beta the sampled spline, gamma coefficients, B[q, r] = beta((m - q) L + r).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Basis:
    """Splines of degree `m` with knots every `L` samples; they sum to one everywhere.

    beta : ndarray, shape ((m + 1) L,)   one spline, beta[0] = 0
    B    : ndarray, shape (m + 1, L)     the spline's pieces, latest first: u on interval j is gamma[j-m..j] @ B
    """

    m: int
    L: int
    beta: np.ndarray
    B: np.ndarray

    def command(self, gamma: np.ndarray, out: np.ndarray) -> None:
        """out[jL + r] = sum_q gamma[j + q] B[q, r], j = 0..n-1: the command of n intervals.

        gamma : ndarray, shape (n + m,), contiguous   coefficients, those that reach into the first interval first
        out   : ndarray, shape (n L,), any stride     [mm]
        """
        n = len(gamma) - self.m
        step = gamma.itemsize
        windows = np.ndarray((n, self.m + 1), float, gamma, 0, (step, step))  # 0.2 us; sliding_window_view takes 7
        out.reshape(n, self.L)[:] = windows.copy() @ self.B

    def free(self, samples: int) -> int:
        """Coefficients whose whole support lies inside a stretch: (n + m) L <= samples - 1."""
        return (samples - 1) // self.L - self.m


def uniform_basis(m: int, L: int) -> Basis:
    """The basis of degree m >= 1 with knots every L samples."""
    x = np.arange((m + 1) * L) / L
    beta = _cardinal(m, x)
    pieces = beta.reshape(m + 1, L)[::-1]
    return Basis(m, L, beta, np.ascontiguousarray(pieces / pieces.sum(axis=0)))


def _cardinal(m: int, x: np.ndarray) -> np.ndarray:
    """Cardinal B-spline N_m(x) on integer knots 0..m+1 (Cox-de Boor for equal spacing)."""
    if m == 0:
        return ((x >= 0) & (x < 1)).astype(float)
    return (x * _cardinal(m - 1, x) + (m + 1 - x) * _cardinal(m - 1, x - 1)) / m
