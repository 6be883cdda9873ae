"""A window of the contour-weighted problem: its band, its right-hand side, its solution.

J = sum_b [wxx_b sum_j lambda_j sum_k (y_x - G_j^x u_x)^2 + wyy_b sum_j lambda_j sum_k (y_y - G_j^y u_y)^2
           + 2 wxy_b sum_k (y_x - Gm^x u_x)(y_y - Gm^y u_y)]    b knot intervals, k samples, Gm mean plant
    + sum_axis mu_axis L sum_i [(gamma_(i+1) - 2 gamma_i + gamma_(i-1)) / (L dt)^2]^2
Each interval takes the family that its first sample came under: models may change along a stretch (`Path.models`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsbmv
from scipy.linalg.lapack import dpbtrf, dpbtrs

from fbfcli.control.admm import Bounds, within
from fbfcli.control.basis import Basis
from fbfcli.control.contour_band import add_band, add_right
from fbfcli.control.contour_gram import ContourGram
from fbfcli.control.contour_weight import IntervalWeights, interval_weights
from fbfcli.control.differences import Differences, add_squares
from fbfcli.control.path import Path
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
        L, known = self.basis.L, past.shape[1]
        gamma = np.concatenate((past, np.zeros((2, windows * self.n_up))), axis=1)
        for k in range(windows):
            here = k * self.n_up
            part = path[here * L : (here + self.n_c) * L + 1]
            solved = self._solve(part, self.n_c, gamma[:, here : here + known].T, None)
            gamma[:, here + known : here + known + self.n_up] = solved[: self.n_up].T
        return gamma[:, known:]

    def closing(self, path: Path, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients of a stretch, shape (2, n); the path ends at rest."""
        if n == 0:
            return np.zeros((2, 0))
        return self._solve(path, n, past.T, path.y[:, -1]).T

    def _solve(self, path: Path, n: int, past: np.ndarray, end: np.ndarray | None) -> np.ndarray:
        """n coefficients of each axis, shape (n, 2), from the path that begins at the first one's knot.

        past : ndarray, shape (k, 2)   coefficients before them
        end  : ndarray, shape (2,)     those after them; None: not known, and the path ends with them
        """
        T, r, before = self._equations(path, n, past, end)
        free = slice(2 * before, 2 * (before + n))
        factor, info = dpbtrf(T.T[:, free], lower=1)
        if info:
            raise ModelError(f"the plants hide splines with knots every {self.basis.L} samples: take wider knots")
        gamma = dpbtrs(factor, r.reshape(-1), lower=1)[0].reshape(n, 2)
        bounds = self._bounds(path, past, end)
        if any(bound.excess(gamma) > 1.0 for bound in bounds):
            gamma = within(T[free], r, bounds, gamma)
        return gamma

    def _equations(self, path: Path, n: int, past: np.ndarray, end: np.ndarray | None
                   ) -> tuple[np.ndarray, np.ndarray, int]:  # fmt: skip
        """The band by columns, the right-hand side (n, 2), and how many fixed coefficients the band begins with."""
        S = max(solver.reach for _, solver in path.models) + 1
        before = min(S - 1, len(past)) if past.any() else 0
        w, Y = self._intervals(path, n if end is None else n + S, end)
        T, r = np.zeros((2 * (before + n + S), 2 * S)), np.zeros((n, 2))
        variable = T[: 2 * (before + n)]  # after these, fixed coefficients among themselves: they stay zero
        starts = [max(0, -(-start // self.basis.L)) for start, _ in path.models]
        for (_, solver), first, stop in zip(path.models, starts, [*starts[1:], len(w.xx)], strict=True):
            here = IntervalWeights(*(each[first:stop] for each in w))
            add_band(variable, solver.gram, here, first, -before)
            add_right(r, solver.gram, here, Y[:, first:stop], first)
        c = np.tile(self.bend, (before + n + 2, 1))
        if end is None:
            c[-2:] = 0.0  # else the unknown after the window would pull its end to the origin
        add_squares(variable, 2, c)
        known = np.zeros((len(T) // 2, 2))
        known[:before] = past[len(past) - before :]
        if end is not None:
            known[before + n :] = end
        pull = dsbmv(2 * S - 1, 1.0, T.T, known.reshape(-1), lower=1)
        return T, r - pull[2 * before : 2 * (before + n)].reshape(n, 2), before

    def _intervals(self, path: Path, N: int, end: np.ndarray | None) -> tuple[IntervalWeights, np.ndarray]:
        """Weights (N,) and desired positions (2, N, L) of a window's intervals; a stretch's end is held at rest."""
        L, w = self.basis.L, interval_weights(path, self.basis.L, self.wt)
        if end is None:
            return IntervalWeights(*(each[:N] for each in w)), path.y[:, : N * L].reshape(2, N, L)
        missing, g = max(0, N - len(w.xx)), path.weight[-1]
        w = IntervalWeights(*(np.concatenate((each[:N], np.full(missing, rest)))
                              for each, rest in zip(w, (g, g, 0.0), strict=True)))  # fmt: skip
        held = np.full((2, max(N * L - path.y.shape[1], 0)), end[:, None])
        return w, np.concatenate((path.y, held), axis=1)[:, : N * L].reshape(2, N, L)

    def _bounds(self, path: Path, past: np.ndarray, end: np.ndarray | None) -> list[Bounds]:
        """|u'| and |u''| in terms of coefficients: a spline's derivatives lie within its coefficients' differences."""
        if not np.isfinite(self.bending).any():
            return []
        known = [np.zeros((0, 2)) if end is None else np.tile(end, (order, 1)) for order in (1, 2)]
        asked = np.abs(np.diff(path.y, axis=1)).max(axis=1, initial=0.0) * self.basis.L
        return [Bounds(Differences(2, past[-2:], known[1]), 100.0 * self.bend, self.bending),
                Bounds(Differences(1, past[-1:], known[0]), 10.0 * self.bend * self.stiff,
                       np.maximum(self.speed, asked))]  # fmt: skip
