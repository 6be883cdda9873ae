"""A window of the contour-weighted problem: its band, its right-hand side, its solution.

J = sum_b [wxx_b sum_j lambda_j sum_k (y_x - G_j^x u_x)^2 + wyy_b sum_j lambda_j sum_k (y_y - G_j^y u_y)^2
           + 2 wxy_b sum_k (y_x - Gm^x u_x)(y_y - Gm^y u_y)]    b knot intervals, k samples, Gm mean plant
    + sum_axis mu_axis L sum_i [(gamma_(i+1) - 2 gamma_i + gamma_(i-1)) / (L dt)^2]^2
With the Gram tensors G of `contour_gram`, A_xx[i, i + d] = sum_s wxx[i + s] Gx[s, d] and so on. Coefficients of X and Y
are interleaved; T[2i, 2d] = xx, T[2i, 2d + 1] = xy, T[2i + 1, 2d] = yy, T[2i + 1, 2d - 1] = yx.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsbmv
from scipy.linalg.lapack import dpbtrf, dpbtrs

from fbfcli.control.admm import Bounds, within
from fbfcli.control.basis import Basis
from fbfcli.control.contour_gram import ContourGram
from fbfcli.control.contour_weight import IntervalWeights, interval_weights
from fbfcli.control.differences import Differences, add_squares
from fbfcli.control.path import Path
from fbfcli.control.projection import projected
from fbfcli.errors import ModelError


@dataclass(frozen=True)
class ContourSolver:
    """Windows of n_c coefficients for each of X and Y; the first n_up are kept.

    bend           : ndarray, shape (2,)         mu L / (L dt)^4: weight on squared second differences
    wt             : weight of an error along the path, against 1 across it
    speed, bending : ndarray, shape (2,)         bounds of first and second differences of coefficients [mm]; inf: none
    stiff          : ndarray, shape (2,)         (w_n L dt)^2: first differences against second ones in the penalties
    """

    basis: Basis
    gram: ContourGram
    bend: np.ndarray
    wt: float
    n_c: int
    n_up: int
    speed: np.ndarray
    bending: np.ndarray
    stiff: np.ndarray

    @property
    def reach(self) -> int:
        """Earlier coefficients that a window hears."""
        return len(self.gram.xx) - 1

    def kept(self, path: Path, windows: int, past: np.ndarray) -> np.ndarray:
        """Coefficients of `windows` windows in a row, shape (2, windows n_up)."""
        L, reach = self.basis.L, self.reach
        gamma = np.concatenate((past[:, past.shape[1] - reach :], np.zeros((2, windows * self.n_up))), axis=1)
        for k in range(windows):
            here = k * self.n_up
            part = path[here * L : (here + self.n_c) * L + 1]
            solved = self._solve(part, self.n_c, gamma[:, here : here + reach].T, None)
            gamma[:, here + reach : here + reach + self.n_up] = solved[: self.n_up].T
        return gamma[:, reach:]

    def closing(self, path: Path, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients of a stretch, shape (2, n); the path ends at rest."""
        if n == 0:
            return np.zeros((2, 0))
        return self._solve(path, n, past[:, past.shape[1] - self.reach :].T, path.y[:, -1]).T

    def _solve(self, path: Path, n: int, past: np.ndarray, end: np.ndarray | None) -> np.ndarray:
        """n coefficients of each axis, shape (n, 2), from the path that begins at the first one's knot.

        past : ndarray, shape (reach, 2)   coefficients before them
        end  : ndarray, shape (2,)         those after them; None: not known, and the path ends with them
        """
        S, before = self.reach + 1, self.reach if past.any() else 0
        w, Y = self._intervals(path, n, end)
        T = np.zeros((2 * (before + n + S), 2 * S))  # the last S columns stay zero: fixed coefficients among themselves
        _put_gram(T[: 2 * (before + n)], self.gram, w, before)
        r = np.empty((n, 2))
        r[:, 0] = projected(self.gram.mean[0], w.xx[:, None] * Y[0] + w.xy[:, None] * Y[1], n)
        r[:, 1] = projected(self.gram.mean[1], w.xy[:, None] * Y[0] + w.yy[:, None] * Y[1], n)
        c = np.tile(self.bend, (before + n + 2, 1))
        if end is None:
            c[-2:] = 0.0  # else the unknown after the window would pull its end to the origin
        add_squares(T[: 2 * (before + n)], 2, c)
        free = slice(2 * before, 2 * (before + n))
        known = np.zeros((len(T) // 2, 2))
        known[:before] = past[:before]
        if end is not None:
            known[before + n :] = end
        r -= dsbmv(2 * S - 1, 1.0, T.T, known.reshape(-1), lower=1)[free].reshape(n, 2)
        factor, info = dpbtrf(T.T[:, free], lower=1)
        if info:
            raise ModelError(f"the plants hide splines with knots every {self.basis.L} samples: take wider knots")
        gamma = dpbtrs(factor, r.reshape(-1), lower=1)[0].reshape(n, 2)
        bounds = self._bounds(path, past, end)
        if any(bound.excess(gamma) > 1.0 for bound in bounds):
            gamma = within(T[free], r, bounds)
        return gamma

    def _intervals(self, path: Path, n: int, end: np.ndarray | None) -> tuple[IntervalWeights, np.ndarray]:
        """Weights (N,) and desired positions (2, N, L) of a window's intervals.

        A stretch's end is held until its last coefficient has died away; N = n where the end is not known.
        """
        L, S = self.basis.L, self.reach + 1
        if end is None:
            weights = IntervalWeights(*(w[:n] for w in interval_weights(path, L, self.wt)))
            return weights, path.y[:, : n * L].reshape(2, n, L)
        N = n + S
        weights = interval_weights(path, L, self.wt)
        after = N - len(weights.xx)
        g = path.weight[-1]
        weights = IntervalWeights(*(np.concatenate((w[:N], np.full(max(after, 0), rest)))
                                    for w, rest in zip(weights, (g, g, 0.0), strict=True)))  # fmt: skip
        held = np.full((2, max(N * L - path.y.shape[1], 0)), end[:, None])
        return weights, np.concatenate((path.y, held), axis=1)[:, : N * L].reshape(2, N, L)

    def _bounds(self, path: Path, past: np.ndarray, end: np.ndarray | None) -> list[Bounds]:
        """|u'| and |u''| in terms of coefficients: a spline's derivatives lie within its coefficients' differences."""
        if not np.isfinite(self.bending).any():
            return []
        known = [np.zeros((0, 2)) if end is None else np.tile(end, (order, 1)) for order in (1, 2)]
        asked = np.abs(np.diff(path.y, axis=1)).max(axis=1, initial=0.0) * self.basis.L
        return [Bounds(Differences(2, past[-2:], known[1]), 100.0 * self.bend, self.bending),
                Bounds(Differences(1, past[-1:], known[0]), 10.0 * self.bend * self.stiff,
                       np.maximum(self.speed, asked))]  # fmt: skip


def _put_gram(T: np.ndarray, gram: ContourGram, w: IntervalWeights, before: int) -> None:
    """The band without the curvature, rows from `before` coefficients ahead of the window on."""
    n, S = len(T) // 2, len(gram.xx)
    hankel = [_hankel(each, n, S, before) for each in w]
    T[0::2, 0::2] = hankel[0] @ gram.xx
    T[1::2, 0::2] = hankel[1] @ gram.yy
    T[0::2, 1::2] = hankel[2] @ gram.xy
    T[1::2, 1 : 2 * S - 1 : 2] = (hankel[2] @ gram.yx)[:, 1:]


def _hankel(w: np.ndarray, n: int, S: int, before: int) -> np.ndarray:
    """H[i, s] = w[i + s - before], zero outside w; shape (n, S)."""
    padded = np.zeros(n + S - 1)
    count = min(len(w), len(padded) - before)
    padded[before : before + count] = w[:count]
    step = padded.itemsize
    return np.ndarray((n, S), float, padded, 0, (step, step)).copy()  # copied: BLAS takes no overlapping rows
