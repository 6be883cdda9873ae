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

SETTLED, AVERAGED = 20, 100  # windows of the power iteration: left out past the plant's memory, then averaged
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
    """The windows' matrices for one axis; `full` must hold n_C coefficients or more. Its `radius` is to be checked."""
    Phi, Phi_P = _rows(full, n_C)
    if mu > 0:
        bent, bent_P = _bending(full.basis, n_C, Phi_P.shape[1])
        Phi, Phi_P = np.vstack((Phi, np.sqrt(mu) * bent)), np.vstack((Phi_P, np.sqrt(mu) * bent_P))
    scale = np.sqrt(np.square(Phi).sum(axis=0))  # late splines have barely begun to show: equal columns
    Q, R, order = qr(Phi / scale, mode="economic", pivoting=True)
    inverse = np.empty_like(Q.T)
    inverse[order] = solve_triangular(R, Q.T)
    pinv = inverse[:n_up] / scale[:n_up, None]
    W, V = pinv[:, : n_C * full.basis.L], pinv @ Phi_P
    return LimitedPreview(np.ascontiguousarray(W), np.ascontiguousarray(V), full)


def _rows(full: FilteredBasis, n_C: int) -> tuple[np.ndarray, np.ndarray]:
    """Phi_C, shape (n_C L, n_C), and Phi_PC, shape (n_C L, Q): the window's samples of its own and earlier splines."""
    S, L = full.psi.shape
    lag = np.arange(n_C)[:, None] - np.arange(-(S - 1), n_C)  # intervals from a spline's knot
    pieces = np.where(((lag >= 0) & (lag < S))[..., None], full.psi[np.clip(lag, 0, S - 1)], 0.0)
    both = pieces.transpose(0, 2, 1).reshape(n_C * L, -1)
    return both[:, S - 1 :], both[:, : S - 1]


def _bending(basis: Basis, n_C: int, n_P: int) -> tuple[np.ndarray, np.ndarray]:
    """Second differences of the command at the window's samples, by its own and by n_P earlier splines."""
    L = basis.L
    v = np.convolve(basis.beta, [1.0, -2.0, 1.0])
    k = np.arange(n_C * L)[:, None] - L * np.arange(-n_P, n_C)
    both = np.where((k >= 0) & (k < len(v)), v[np.clip(k, 0, len(v) - 1)], 0.0)
    return both[:, n_P:], both[:, :n_P]
