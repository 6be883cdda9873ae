"""Figures of a compensated print that are collected while it streams past."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fbfcli.motion.profile import Profile
from fbfcli.motion.sample import sample
from fbfcli.verify.contour_error import ErrorTally, contour_error
from fbfcli.verify.simulate import Nozzle

STRIDE = 4  # samples between those whose contour error is measured


@dataclass(frozen=True)
class Stretches:
    """Samples of stretches that have been written. n samples, s stretches, k segments.

    begin, end : ndarray of int, shape (s,)        first and last sample of each
    rest       : ndarray of int, shape (s,)        samples of rest before each
    desired, command : ndarray, shape (n, 2)       [mm]
    extruding  : ndarray of bool, shape (n,)
    first      : ndarray of int, shape (s,)        first segment of each
    start, delta : ndarray, shape (k, 4)           segments as written [mm]
    distance   : ndarray, shape (k,)
    wanted     : ndarray, shape (k,)               time each should last [s]
    executed   : Profile                           what the planner model makes of them
    dt         : float
    """

    begin: np.ndarray
    end: np.ndarray
    rest: np.ndarray
    desired: np.ndarray
    command: np.ndarray
    extruding: np.ndarray
    first: np.ndarray
    start: np.ndarray
    delta: np.ndarray
    distance: np.ndarray
    wanted: np.ndarray
    executed: Profile
    dt: float

    def positions(self) -> np.ndarray:
        """X and Y that the planner model executes, on the samples, shape (n, 2)."""
        counts = np.diff(np.append(self.first, len(self.distance)))
        elapsed = np.cumsum(self.executed.duration) - self.executed.duration
        t0 = elapsed + np.repeat(self.begin * self.dt - elapsed[self.first], counts)
        x, _ = sample(self.start[:, :2], self.delta[:, :2], self.distance, self.executed, t0, len(self.desired), self.dt)
        x[self.begin] = self.start[self.first, :2]
        return x


@dataclass
class Tally:
    """What the written file does on the printer's own model, so far."""

    plants: Sequence[tuple[np.ndarray, np.ndarray]]
    follow: ErrorTally = field(default_factory=ErrorTally)
    before: ErrorTally = field(default_factory=ErrorTally)
    after: ErrorTally = field(default_factory=ErrorTally)
    segments: int = 0
    wanted_s: float = 0.0
    executed_s: float = 0.0
    busiest: int = 0  # segments within one second

    def __post_init__(self) -> None:
        self._uncompensated, self._compensated = Nozzle(self.plants), Nozzle(self.plants)

    def add(self, part: Stretches) -> None:
        """Execute the written segments, drive the plant, and count the errors."""
        self.segments += len(part.distance)
        self.wanted_s += float(part.wanted.sum())
        self.executed_s += float(part.executed.duration.sum())
        self.busiest = max(self.busiest, _busiest(part))
        x = part.positions()
        ex, ey = x[:, 0] - part.command[:, 0], x[:, 1] - part.command[:, 1]
        self.follow.add(np.sqrt(ex * ex + ey * ey))
        at = np.flatnonzero(part.extruding[::STRIDE]) * STRIDE
        stretch = np.searchsorted(part.begin, at, side="right") - 1
        first, last = part.begin[stretch], part.end[stretch]
        for command, nozzle, errors in (
            (part.desired, self._uncompensated, self.before),
            (x, self._compensated, self.after),
        ):
            errors.add(contour_error(nozzle.follow(command, part.begin, part.rest), part.desired, at, first, last))

    @property
    def drift_ppm(self) -> float:
        """How much longer the written file takes than it should, in parts per million."""
        return 1e6 * (self.executed_s / self.wanted_s - 1.0) if self.wanted_s else 0.0

    @property
    def rate(self) -> float:
        """Segments per second of compensated motion."""
        return self.segments / self.wanted_s if self.wanted_s else 0.0


def _busiest(part: Stretches) -> int:
    """Most segments that begin within one second."""
    second = (np.cumsum(part.wanted) - part.wanted).astype(np.int64)
    return int(np.bincount(second).max()) if len(second) else 0
