"""Differences of two axes' coefficients, and the band of their weighted squares.

Coefficients are interleaved, x_0, y_0, x_1, y_1, ...; a band is kept by columns, T[column, d] = A[column + d, column],
so that T.T is LAPACK's lower band.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np


@dataclass(frozen=True)
class Differences:
    """Differences of one order along (before, free, after); `after` is empty where nothing is known there.

    order         : int
    before, after : ndarray, shape (order, axes), (order or 0, axes)
    """

    order: int
    before: np.ndarray
    after: np.ndarray

    def of(self, gamma: np.ndarray) -> np.ndarray:
        """D g + e of the free coefficients, shape (n, axes)."""
        return np.diff(np.concatenate((self.before, gamma, self.after)), self.order, axis=0)

    def back(self, v: np.ndarray) -> np.ndarray:
        """D' v, one row for each free coefficient."""
        pad = np.zeros((self.order, v.shape[1]))
        every = (-1) ** self.order * np.diff(np.concatenate((pad, v, pad)), self.order, axis=0)
        return every[self.order : len(every) - len(self.after)]


def add_squares(T: np.ndarray, order: int, c: np.ndarray) -> None:
    """Add sum_t c_t (difference of `order` that begins at t)^2 to a band.

    T : ndarray, shape (2 n, 2 S), S > order
    c : ndarray, shape (n + order, 2)   from t = -order on; zero where the difference does not count
    """
    n = len(T) // 2
    signed = [(-1) ** k * comb(order, k) for k in range(order + 1)]
    columns = T.reshape(n, 2, -1)
    for d in range(order + 1):
        products = [signed[a] * signed[a + d] for a in range(order + 1 - d)]
        columns[:, :, 2 * d] += sum(p * c[order - a : order - a + n] for a, p in enumerate(products))
