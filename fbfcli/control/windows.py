"""Spline commands in windows: n_C coefficients are solved, the first n_up kept, until the stretch's end is near.

p    coefficients kept so far: the stretch's command is final before sample p L
past the last coefficients before p, all that a later sample can still hear
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fbfcli.control.basis import Basis
from fbfcli.control.compensator import Stream


class AxisSolver(Protocol):
    """One axis' coefficients. Positions are relative to the stretch's start."""

    @property
    def reach(self) -> int:
        """Earlier coefficients that it needs."""
        ...

    def kept(self, y: np.ndarray, windows: int, past: np.ndarray) -> np.ndarray:
        """Coefficients kept of `windows` windows in a row, shape (windows n_up,); y starts at the first one's knot."""
        ...

    def closing(self, y: np.ndarray, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients of a stretch; y ends at rest."""
        ...


@dataclass(frozen=True)
class SplineCompensator:
    """Axis by axis, with a common basis; the samples' weights are ignored.

    n_c, n_up : coefficients of a window, and of those that are kept
    solvers : one AxisSolver per axis
    harder  : makes the same with ten times the weight mu, None after the last step
    """

    name: str
    basis: Basis
    n_c: int
    n_up: int
    solvers: Sequence[AxisSolver]
    harder: Callable[[], SplineCompensator] | None = None
    lead: int = 0
    tail: int = 0

    @property
    def settle(self) -> int:
        """m L + 1 samples: a step from rest to rest takes m intervals of a spline of degree m."""
        return self.basis.m * self.basis.L + 1

    @property
    def preview(self) -> int:
        """The last sample a coefficient of a window may depend on, seen from its first."""
        return (self.n_c + self.basis.m + 1) * self.basis.L

    def start(self, y_0: np.ndarray) -> SplineStream:
        """A stretch that rests at y_0, shape (axes,) [mm], before it."""
        return SplineStream(self, np.array(y_0, float))

    def resume(self, stream: Stream) -> SplineStream:
        """The same stretch from where it is, with this weight; both designs have the same basis and plant."""
        if not isinstance(stream, SplineStream):
            raise TypeError("another method's stretch")
        return stream.under(self)

    def stiffer(self) -> SplineCompensator | None:
        """The same with ten times the weight on the command's curvature."""
        return self.harder() if self.harder else None


class SplineStream:
    """One stretch of a SplineCompensator: remembers the samples from p L on and the coefficients before p."""

    def __init__(self, design: SplineCompensator, y_0: np.ndarray):
        self._design, self._y_0 = design, y_0
        self._y = np.zeros((len(y_0), 0))
        self._past = [np.zeros(max(solver.reach, design.basis.m)) for solver in design.solvers]
        self._end = self._y_0  # the last desired position so far

    def under(self, design: SplineCompensator) -> SplineStream:
        """A copy that goes on with another design."""
        copy = SplineStream(design, self._y_0)
        copy._y, copy._past, copy._end = self._y, list(self._past), self._end
        return copy

    def push(self, y_d: np.ndarray, weight: np.ndarray, last: bool) -> np.ndarray:
        """Commands final now, shape (m, axes) [mm]; see Stream.push. Weights are ignored."""
        basis, n_up = self._design.basis, self._design.n_up
        y = np.concatenate((self._y, (y_d - self._y_0).T), axis=1)
        self._end = y_d[-1] if len(y_d) else self._end
        free = basis.free(y.shape[1])
        windows = max(0, -((self._design.n_c - free) // n_up)) if free > self._design.n_c else 0
        n_kept = windows * n_up
        if last and free < 0:  # too short to move and rest; a stretch of kept windows has more than n_C - n_up left
            return self._ending(y.T + self._y_0, -1)
        n = free - n_kept if last else 0
        intervals = -(-y.shape[1] // basis.L) if last else n_kept
        u = np.empty((intervals * basis.L, len(y)))
        for axis, solver in enumerate(self._design.solvers):
            gamma = self._past[axis]
            if windows:
                gamma = np.concatenate((gamma, solver.kept(y[axis], windows, gamma)))
            self._past[axis] = gamma[len(gamma) - len(self._past[axis]) :]
            if last:
                end = y[axis, -1]
                closing = solver.closing(y[axis, n_kept * basis.L :], n, self._past[axis])
                gamma = np.concatenate((gamma, closing, np.full(intervals - n_kept - n, end)))
            basis.command(gamma[len(gamma) - intervals - basis.m :], u[:, axis])
        self._y = y[:, n_kept * basis.L :].copy()
        u += self._y_0
        return self._ending(u[: y.shape[1]], (n_kept + n + basis.m) * basis.L) if last else u

    def _ending(self, u: np.ndarray, rest: int) -> np.ndarray:
        """u, exactly at the last desired position from sample `rest` on."""
        u[rest:] = self._end
        return u
