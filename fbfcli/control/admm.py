"""Banded least squares with bounds on differences, by the alternating direction method of multipliers.

minimise 1/2 g'T g - r'g  subject to  |D g + e| <= bound       Boyd et al. 2011, Sec. 5.2, over-relaxed (3.4.3)
    g <- (T + D'K D)^-1 (r + D'K (z - w - e)),  d = D g + e
    v = a d + (1 - a) z,  z <- clip(v + w, bound),  w <- w + v - z
K holds a penalty for each axis. T and D'K D are banded: one factorisation serves all steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs

from fbfcli.control.differences import Differences, add_squares

RELAXED = 1.6
STEPS = 500  # back-substitutions at most
EVERY = 10  # of them between looks at the bounds
CLOSE = 0.01  # of a bound: what a solution may leave it by, and change by between two looks


class Bounds(NamedTuple):
    """|differences| <= bound.

    penalty, bound : ndarray, shape (axes,)
    """

    differences: Differences
    penalty: np.ndarray
    bound: np.ndarray

    def excess(self, gamma: np.ndarray) -> float:
        """Largest |difference| / bound."""
        return float((np.abs(self.differences.of(gamma)) / self.bound).max())


def within(T: np.ndarray, r: np.ndarray, bounds: Sequence[Bounds]) -> np.ndarray:
    """The coefficients, shape (n, 2), that keep the bounds to CLOSE of them, if STEPS are enough.

    T : ndarray, shape (2 n, 2 S)   band of the problem, by columns
    r : ndarray, shape (n, 2)       right-hand side
    """
    n = len(r)
    stiff = T.copy()
    for differences, penalty, _ in bounds:
        c = np.tile(penalty, (n + differences.order, 1))
        if not len(differences.after):
            c[n:] = 0.0
        add_squares(stiff, differences.order, c)
    factor, _ = dpbtrf(stiff.T, lower=1, overwrite_ab=1)
    still = np.zeros((n, 2))
    e = [bound.differences.of(still) for bound in bounds]
    z = [np.zeros_like(e_i) for e_i in e]
    w = [np.zeros_like(e_i) for e_i in e]
    before = still
    gamma = still
    for step in range(STEPS):
        right = r.copy()
        for i, (differences, penalty, _) in enumerate(bounds):
            right += differences.back(penalty * (z[i] - w[i] - e[i]))
        gamma = dpbtrs(factor, right.reshape(-1), lower=1, overwrite_b=1)[0].reshape(n, 2)
        for i, (differences, _, bound) in enumerate(bounds):
            v = RELAXED * differences.of(gamma) + (1.0 - RELAXED) * z[i]
            z[i] = np.clip(v + w[i], -bound, bound)
            w[i] += v - z[i]
        if step % EVERY == EVERY - 1:
            if max(bound.excess(gamma) for bound in bounds) < 1.0 + CLOSE and _settled(gamma - before, bounds):
                break
            before = gamma
    return gamma


def _settled(change: np.ndarray, bounds: Sequence[Bounds]) -> bool:
    """Differences change by less than CLOSE of their bounds."""
    return all((np.abs(np.diff(change, differences.order, axis=0)) < CLOSE * bound).all()
               for differences, _, bound in bounds)  # fmt: skip
