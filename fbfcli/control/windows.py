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
from fbfcli.control.path import Path, resting

MEMORY = 2  # times what a design hears: another one, of a slower plant, may go on


class Solver(Protocol):
    """All axes' coefficients. Positions are relative to the stretch's start; the path begins at a knot."""

    @property
    def reach(self) -> int:
        """Earlier coefficients that it needs."""
        ...

    def kept(self, path: Path, windows: int, past: np.ndarray) -> np.ndarray:
        """Coefficients kept of `windows` windows in a row, shape (axes, windows n_up); past (axes, reach or more)."""
        ...

    def closing(self, path: Path, n: int, past: np.ndarray) -> np.ndarray:
        """The last n coefficients of a stretch, shape (axes, n); the path ends at rest."""
        ...


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
class AxisByAxis:
    """Each axis on its own; the samples' weights are ignored."""

    solvers: Sequence[AxisSolver]

    @property
    def reach(self) -> int:
        """What the longest of them needs."""
        return max(solver.reach for solver in self.solvers)

    def kept(self, path: Path, windows: int, past: np.ndarray) -> np.ndarray:
        """See Solver.kept."""
        return np.array([axis.kept(y, windows, p) for axis, y, p in zip(self.solvers, path.y, past, strict=True)])

    def closing(self, path: Path, n: int, past: np.ndarray) -> np.ndarray:
        """See Solver.closing."""
        return np.array([axis.closing(y, n, p) for axis, y, p in zip(self.solvers, path.y, past, strict=True)])


@dataclass(frozen=True)
class SplineCompensator:
    """A method that chooses a spline's coefficients; all axes have one basis.

    n_c, n_up : coefficients of a window, and of those that are kept
    harder    : makes the same with ten times the weight mu, None after the last step
    ahead     : samples that a filtered spline begins before the spline itself, whole knots: it has heard them too
    within_windows : the solver knows under which design each sample came
    """

    name: str
    basis: Basis
    n_c: int
    n_up: int
    solver: Solver
    harder: Callable[[], SplineCompensator] | None = None
    lead: int = 0
    tail: int = 0
    ahead: int = 0
    within_windows: bool = False

    @property
    def settle(self) -> int:
        """m L + 1 samples: a step from rest to rest takes m intervals of a spline of degree m."""
        return self.basis.m * self.basis.L + 1

    @property
    def notice(self) -> int:
        """Of another design: none where windows take each sample's own plants, else what a window looks ahead."""
        return 0 if self.within_windows else self.preview

    @property
    def preview(self) -> int:
        """The last sample a coefficient of a window may depend on, seen from its first."""
        return (self.n_c + self.basis.m + 1) * self.basis.L

    def start(self, y_0: np.ndarray) -> SplineStream:
        """A stretch that rests at y_0, shape (axes,) [mm], before it."""
        return SplineStream(self, np.array(y_0, float))

    def resume(self, stream: Stream) -> SplineStream:
        """The same stretch from where it is, with this weight; both designs have the same basis."""
        if not isinstance(stream, SplineStream):
            raise TypeError("another method's stretch")
        return stream.under(self)

    def stiffer(self) -> SplineCompensator | None:
        """The same with ten times the weight on the command's curvature."""
        return self.harder() if self.harder else None


class SplineStream:
    """One stretch of a SplineCompensator: remembers the path from where p L is heard, and the coefficients before p."""

    def __init__(self, design: SplineCompensator, y_0: np.ndarray):
        self._design, self._y_0 = design, y_0
        self._path = resting(len(y_0), design.ahead, design.solver)
        self._past = np.zeros((len(y_0), MEMORY * max(design.solver.reach, design.basis.m)))
        self._end = self._y_0  # the last desired position so far

    def under(self, design: SplineCompensator) -> SplineStream:
        """A copy that goes on with another design."""
        copy = SplineStream(design, self._y_0)
        copy._path, copy._end = self._path, self._end
        missing = max(0, copy._past.shape[1] - self._past.shape[1])
        copy._past = np.pad(self._past, ((0, 0), (missing, 0)), "edge")
        return copy

    def push(self, y_d: np.ndarray, weight: np.ndarray, last: bool) -> np.ndarray:
        """Commands final now, shape (m, axes) [mm]; see Stream.push."""
        design, solver, L = self._design, self._design.solver, self._design.basis.L
        path = self._path.then((y_d - self._y_0).T, weight, solver)
        self._end = y_d[-1] if len(y_d) else self._end
        count = len(path.weight) - design.ahead
        free = design.basis.free(count)
        windows = max(0, -((design.n_c - free) // design.n_up)) if free > design.n_c else 0
        n_kept = windows * design.n_up
        if last and free < 0:  # too short to move and rest; a stretch of kept windows has more than n_C - n_up left
            return self._ending(path.y[:, design.ahead :].T + self._y_0, -1)
        n = free - n_kept if last else 0
        intervals = -(-count // L) if last else n_kept
        gamma = self._past
        if windows:
            gamma = np.concatenate((gamma, solver.kept(path, windows, gamma)), axis=1)
        self._path = path[n_kept * L :]
        self._past = gamma[:, gamma.shape[1] - self._past.shape[1] :]
        if last:
            closing = solver.closing(self._path, n, self._past)
            held = np.repeat(path.y[:, -1:], intervals - n_kept - n, axis=1)
            gamma = np.concatenate((gamma, closing, held), axis=1)
        u = self._command(gamma, intervals)
        return self._ending(u[:count], (n_kept + n + design.basis.m) * L) if last else u

    def _command(self, gamma: np.ndarray, intervals: int) -> np.ndarray:
        """The command on the intervals that the last coefficients belong to, shape (intervals L, axes)."""
        basis = self._design.basis
        u = np.empty((intervals * basis.L, len(gamma)))
        for axis, each in enumerate(gamma):
            basis.command(np.ascontiguousarray(each[len(each) - intervals - basis.m :]), u[:, axis])
        u += self._y_0
        return u

    def _ending(self, u: np.ndarray, rest: int) -> np.ndarray:
        """u, exactly at the last desired position from sample `rest` on."""
        u[rest:] = self._end
        return u
