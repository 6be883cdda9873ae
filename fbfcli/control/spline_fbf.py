"""Filtered B-splines with full preview on uniform knots: a banded symmetric Toeplitz system.

gamma minimises sum_k (y[k] - sum_i gamma_i psi[k - iL])^2 + mu sum_k (second difference of u)[k]^2 (Ramani 2020
Eq. 2.10 with the basis of Ramani 2020b App. B), where psi = h * beta is the filtered spline. With
    R_d = sum_k psi[k + dL] psi[k] + mu sum_k v[k + dL] v[k]        v = second difference of beta
    r_i = sum_k psi[k - iL] y[k]
the normal equations are T gamma = r, T_ij = R_|i-j|. The Cholesky factor of the leading n x n block of T is the leading
block of T's factor, so one factorisation serves stretches of every length.
Positions are relative to the stretch's start, where everything rests at 0; the end rests at Delta.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpbtrf, dpbtrs

from fbfcli.control.basis import Basis
from fbfcli.control.projection import projected
from fbfcli.errors import ModelError

FELT = 1e-11  # of a step at a window's end: the path of the next few knots there is some 10 mm, so 1e-10 mm
SINGULAR = 1e-12  # a pivot under this part of the diagonal: the plant hides that spline from its output


@dataclass(frozen=True)
class FilteredBasis:
    """One axis' filtered splines and the factor of their normal equations.

    psi    : ndarray, shape (S, L)           filtered spline, cut at the knots, zero at its end
    R      : ndarray, shape (Q + 1,)         one row of T
    factor : ndarray, shape (Q + 1, n_max)   lower Cholesky band of T, Fortran order (LAPACK dpbtrf)
    tail   : ndarray, shape (S L + 1,)       tail[p] = sum of psi from sample p on
    held   : ndarray, shape (Q + 2,)         held[d] = R_d + R_(d+1) + ...
    """

    basis: Basis
    psi: np.ndarray
    R: np.ndarray
    factor: np.ndarray
    tail: np.ndarray
    held: np.ndarray

    def solve(self, y: np.ndarray, n: int, end: float, past: np.ndarray | None) -> np.ndarray:
        """The n free coefficients of samples y that rest at `end` from there on, shape (n,).

        y    : ndarray, contiguous   desired position from the first coefficient's knot on, (n + m) L samples or more
        past : ndarray, shape (Q,)   coefficients before the first; None where all are zero
        """
        if n == 0:
            return np.zeros(0)
        r = self._projected(y, n)
        Q, L = len(self.R) - 1, self.basis.L
        first = max(0, (len(y) - len(self.tail)) // L + 1)  # coefficients whose response outlasts the samples
        if first < n:
            stop = len(y) - first * L
            r[first:] += end * self.tail[stop : stop - (n - first) * L : -L]
        reach = min(n, Q)
        r[n - reach :] -= end * self.held[reach:0:-1]
        if past is not None and past.any():
            r[:reach] -= np.convolve(past, self.R)[Q : Q + reach]
        gamma, _ = dpbtrs(self.factor[:, :n], r, lower=1, overwrite_b=1)
        return gamma

    def _projected(self, y: np.ndarray, n: int) -> np.ndarray:
        """r_i = sum_k psi[k - iL] y[k] for i < n; samples past the end count as zero."""
        S, L = self.psi.shape
        heard = y[: (n - 1 + S) * L]
        Y = np.zeros((-(-len(heard) // L), L))
        Y.reshape(-1)[: len(heard)] = heard
        return projected(self.psi, Y, n)


def filtered_basis(basis: Basis, family: Sequence[np.ndarray], weights: np.ndarray, mu: float,
                   n_max: int) -> FilteredBasis:  # fmt: skip
    """For impulse responses of sum 1 and stretches of at most n_max coefficients.

    Of several plants, the expected squared error is made least: r takes their mean psi, R their mean R.

    Raises ModelError where the plant answers some combination of splines with nothing.
    """
    L = basis.L
    filtered = [np.convolve(h, basis.beta) for h in family]
    S = max(-(-len(f) // L) for f in filtered)
    psi, R = np.zeros(S * L), np.zeros(S)
    for f, weight in zip(filtered, weights.tolist(), strict=True):
        psi[: len(f)] += weight * f
        each = _autocorrelation(f, L)
        R[: len(each)] += weight * each
    v = np.convolve(basis.beta, [1.0, -2.0, 1.0])
    bent = mu * _autocorrelation(v, L)
    R[: len(bent)] += bent[: len(R)]
    Q = S - 1
    band = np.zeros((Q + 1, n_max), order="F")
    band[:] = R[:, None]
    factor, info = dpbtrf(band, lower=1, overwrite_ab=1)
    if info != 0 or factor[0].min() ** 2 < SINGULAR * R[0]:
        raise ModelError(f"the plant hides splines with knots every {L} samples: take wider knots or a larger mu")
    tail = np.append(np.cumsum(psi[::-1])[::-1], 0.0)
    held = np.append(np.cumsum(R[::-1])[::-1], 0.0)
    return FilteredBasis(basis, np.ascontiguousarray(psi.reshape(S, L)), R, factor, tail, held)


def _autocorrelation(x: np.ndarray, L: int) -> np.ndarray:
    """sum_k x[k + dL] x[k] for d = 0, 1, ... while x overlaps itself."""
    return np.correlate(x, x, "full")[len(x) - 1 :: L]


@dataclass(frozen=True)
class FullPreview:
    """Windows of a stretch that is longer than the factor: earlier coefficients fixed, the future held.

    n_c, n_up : coefficients solved and kept; the rest is preview enough that the held future is not felt
    """

    full: FilteredBasis
    n_c: int
    n_up: int

    @property
    def reach(self) -> int:
        """Earlier coefficients that a window hears."""
        return len(self.full.R) - 1

    def kept(self, y: np.ndarray, windows: int, past: np.ndarray) -> np.ndarray:
        """Coefficients of `windows` windows, shape (windows n_up,)."""
        L, reach = self.full.basis.L, self.reach
        gamma = np.concatenate((past[len(past) - reach :], np.zeros(windows * self.n_up)))
        for k in range(windows):
            here = k * self.n_up
            part = y[here * L : (here + self.n_c + self.full.basis.m) * L + 1]
            solved = self.full.solve(part, self.n_c, part[-1], gamma[here : here + reach])
            gamma[here + reach : here + reach + self.n_up] = solved[: self.n_up]
        return gamma[reach:]

    def closing(self, y: np.ndarray, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients, end held: exact given the past."""
        return self.full.solve(y, n, y[-1], past[len(past) - self.reach :])


def forgetting(full: FilteredBasis) -> int:
    """Coefficients from a window's end to where a change of what comes after it is felt less than FELT.

    Changes tried: of the last equation, of the desired positions after the end, of the coefficients after the end.
    """
    n, L = full.factor.shape[1], full.basis.L
    changes = np.zeros((n, 3), order="F")
    changes[-1, 0] = 1.0
    after = full.tail[(full.basis.m + 1) * L :: L][:n]
    changes[n - len(after) :, 1] = after[::-1]
    reach = min(n, len(full.R) - 1)
    changes[n - reach :, 2] = full.held[reach:0:-1]
    x, _ = dpbtrs(full.factor, changes, lower=1)
    felt = np.abs(x[::-1]) > FELT * np.abs(x).max(axis=0)
    return int(np.flatnonzero(felt.any(axis=1)).max(initial=0)) + 1
