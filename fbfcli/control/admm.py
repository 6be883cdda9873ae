"""Banded least squares with bounds on differences, by the alternating direction method of multipliers.

minimise 1/2 g'T g - r'g  subject to  |D g + e| <= bound       Boyd et al. 2011, Sec. 5.2, over-relaxed (3.4.3)
    g <- (T + D'K D)^-1 (r + D'K (z - w - e)),  d = D g + e
    v = a d + (1 - a) z,  z <- clip(v + w, bound),  w <- w + v - z
K holds a penalty for each axis. T and D'K D are banded: one factorisation serves all steps of a round. Where bounds are
far below what the path asks for, the next round has larger penalties (w, which counts in their units, shrinks).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs

from fbfcli.control.differences import Differences, add_squares

RELAXED = 1.6
ROUNDS, STEPS = 12, 60  # factorisations, and back-substitutions of each, at most
EVERY = 10  # of these between looks at the bounds
HARDER = 3.0  # times the penalties of the round before
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


class _Split:
    """One set of bounds as the steps see it: z its differences within the bounds, w the price of their being there."""

    def __init__(self, bounds: Bounds, gamma: np.ndarray):
        self.bounds, self.penalty = bounds, bounds.penalty
        self.fixed = bounds.differences.of(np.zeros_like(gamma))
        self.z = np.clip(bounds.differences.of(gamma), -bounds.bound, bounds.bound)
        self.w = np.zeros_like(self.z)

    def harden(self) -> None:
        self.penalty = HARDER * self.penalty
        self.w /= HARDER

    def pull(self) -> np.ndarray:
        """D'K (z - w - e)."""
        return self.bounds.differences.back(self.penalty * (self.z - self.w - self.fixed))

    def follow(self, gamma: np.ndarray) -> None:
        """z and w after g."""
        v = RELAXED * self.bounds.differences.of(gamma) + (1.0 - RELAXED) * self.z
        self.z = np.clip(v + self.w, -self.bounds.bound, self.bounds.bound)
        self.w += v - self.z


def within(T: np.ndarray, r: np.ndarray, bounds: Sequence[Bounds], gamma: np.ndarray) -> np.ndarray:
    """The coefficients, shape (n, 2), that keep the bounds to CLOSE of them, if ROUNDS are enough.

    T     : ndarray, shape (2 n, 2 S)   band of the problem, by columns
    r     : ndarray, shape (n, 2)       right-hand side
    gamma : ndarray, shape (n, 2)       the coefficients without bounds
    """
    splits = [_Split(bound, gamma) for bound in bounds]
    before = gamma
    for turn in range(ROUNDS):
        if turn:
            for split in splits:
                split.harden()
        factor = _factor(T, splits)
        for step in range(STEPS):
            right = r + sum(split.pull() for split in splits)
            gamma = dpbtrs(factor, right.reshape(-1), lower=1, overwrite_b=1)[0].reshape(r.shape)
            for split in splits:
                split.follow(gamma)
            if step % EVERY == EVERY - 1:
                if _done(gamma, before, bounds):
                    return gamma
                before = gamma
    return gamma


def _factor(T: np.ndarray, splits: Sequence[_Split]) -> np.ndarray:
    """Cholesky factor of T + D'K D."""
    stiff = T.copy()
    for split in splits:
        order, n = split.bounds.differences.order, len(T) // 2
        c = np.tile(split.penalty, (n + order, 1))
        if not len(split.bounds.differences.after):
            c[n:] = 0.0
        add_squares(stiff, order, c)
    return np.asarray(dpbtrf(stiff.T, lower=1, overwrite_ab=1)[0])


def _done(gamma: np.ndarray, before: np.ndarray, bounds: Sequence[Bounds]) -> bool:
    """Bounds are kept, and differences change by less than CLOSE of them."""
    return all(
        bound.excess(gamma) < 1.0 + CLOSE
        and (np.abs(np.diff(gamma - before, bound.differences.order, axis=0)) < CLOSE * bound.bound).all()
        for bound in bounds
    )
