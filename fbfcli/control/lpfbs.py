"""Limited-preview filtered B-splines, Ramani 2020b App. B, Eq. 23-24.

A window of n_C coefficients is fitted to its L_C = n_C L samples alone, the response of earlier coefficients
subtracted; the first n_up are kept:
    gamma_C = Phi_C^+ (y_C - Phi_PC gamma_P)
With W = the first n_up rows of Phi_C^+ and V = W Phi_PC this is c = W y for all windows at once and a short recursion
gamma_up = c - V gamma_P. The last window of a stretch is solved as with full preview: its end is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from fbfcli.control.basis import Basis
from fbfcli.control.spline_fbf import FilteredBasis
from fbfcli.errors import ModelError

SETTLED, AVERAGED = 20, 100  # windows of the power iteration: left out past the plant's memory, then averaged
EARLIER = 64  # splines before a window whose samples are held at once
UNSTABLE = 0.5  # radius per window from which a design is refused: errors of one window must die in the next few


@dataclass(frozen=True)
class LimitedPreview:
    """One axis' windows.

    W     : ndarray, shape (n_up, n_C L)     kept coefficients of the window's samples
    V     : ndarray, shape (n_up, reach)     and of the coefficients before it
    full  : FilteredBasis                    for the last window
    """

    W: np.ndarray
    V: np.ndarray
    full: FilteredBasis

    @property
    def reach(self) -> int:
        """Earlier coefficients that a window hears."""
        return self.V.shape[1]

    @property
    def radius(self) -> float:
        """Spectral radius of the map from the coefficients before a window to those before the next (power method)."""
        gamma = np.random.default_rng(0).standard_normal(self.reach)
        settled = SETTLED + self.reach // len(self.W)
        growth = np.ones(settled + AVERAGED)
        for k in range(len(growth)):
            gamma = np.concatenate((gamma, -self.V @ gamma))[-self.reach :]
            growth[k] = np.sqrt(gamma @ gamma)
            if growth[k] == 0.0:
                return 0.0
            gamma /= growth[k]
        return float(np.exp(np.log(growth[settled:]).mean()))

    def kept(self, y: np.ndarray, windows: int, past: np.ndarray) -> np.ndarray:
        """gamma_up of `windows` windows, shape (windows n_up,)."""
        n_up = len(self.W)
        step = n_up * self.full.basis.L
        c = np.zeros((windows, n_up))
        for start in range(0, self.W.shape[1], step):  # W in blocks of one window step: no sample is copied
            block = self.W[:, start : start + step]
            rows = y[start : start + windows * step]
            short = windows * step - len(rows)
            if short:
                rows = np.concatenate((rows, np.zeros(short)))
            c += rows.reshape(windows, step)[:, : block.shape[1]] @ block.T
        reach = self.reach
        gamma = np.concatenate((past[len(past) - reach :], np.zeros(windows * n_up)))
        for k in range(windows):
            here = k * n_up
            gamma[here + reach : here + reach + n_up] = c[k] - self.V @ gamma[here : here + reach]
        return gamma[reach:]

    def closing(self, y: np.ndarray, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients, end held: exact given the past."""
        return self.full.solve(y, n, y[-1], past[len(past) - self.reach :])


def limited_preview(full: FilteredBasis, mu: float, n_C: int, n_up: int) -> LimitedPreview:
    """The windows' matrices for one axis; `full` must hold n_C coefficients or more. Its `radius` is to be checked.

    With Phi_C P = Q R, the first n_up rows of Phi_C^+ are X Q^T, X those rows of P R^-1. At most one matrix of Phi_C's
    size is held, and the QR is done in its place. Raises ModelError where a spline does not show in its window.
    """
    Phi = _splines(full, mu, n_C, 0, n_C)
    scale = np.sqrt(np.einsum("ij,ij->j", Phi, Phi))  # late splines have barely begun to show: equal columns
    if not scale.all():
        raise ModelError(f"windows end before their last spline shows: knots every {full.basis.L} samples are too near")
    Phi /= scale
    Q, R, order = qr(Phi, overwrite_a=True, mode="economic", pivoting=True)
    kept = np.zeros((n_C, n_up))
    kept[np.argsort(order)[:n_up], np.arange(n_up)] = 1.0 / scale[:n_up]
    X = solve_triangular(R, kept, trans="T").T
    earlier = range(1 - len(full.psi), 0, EARLIER)
    heard = [Q.T @ _splines(full, mu, n_C, first, min(first + EARLIER, 0)) for first in earlier]
    W, V = X @ Q[: n_C * full.basis.L].T, X @ np.hstack(heard)
    return LimitedPreview(np.ascontiguousarray(W), np.ascontiguousarray(V), full)


def _splines(full: FilteredBasis, mu: float, n_C: int, first: int, stop: int) -> np.ndarray:
    """Columns of (Phi_PC, Phi_C): a window's samples of splines first to stop - 1, its own beginning with 0, shape
    (n_C L, stop - first); where mu > 0, more rows below them, whose squares are mu times those of the bending.
    """
    shown = [full.psi] if mu == 0 else [full.psi, np.sqrt(mu) * _bending(full.basis)]
    ends = n_C * np.cumsum([one.shape[1] for one in shown])
    columns = np.zeros((stop - first, ends[-1]))
    for i, column in zip(range(first, stop), columns, strict=True):
        for one, rows in zip(shown, np.split(column, ends[:-1]), strict=True):
            inside = one[max(-i, 0) : n_C - i]
            rows.reshape(n_C, -1)[max(i, 0) :][: len(inside)] = inside
    return columns.T


def _bending(basis: Basis) -> np.ndarray:
    """Second differences of a spline by intervals, shape (intervals, rows): of the L rows of an interval no more than
    there are splines in it. One rotation for all intervals does it, which leaves every sum of squares.
    """
    v = np.convolve(basis.beta, [1.0, -2.0, 1.0])
    v = np.concatenate((v, np.zeros(-len(v) % basis.L)))
    _, R = qr(v.reshape(-1, basis.L).T, mode="economic")
    return np.asarray(R.T)
