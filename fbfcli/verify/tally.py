"""Figures of a compensated print that are collected while it streams past."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.motion.polyline import Polyline
from fbfcli.motion.profile import Profile
from fbfcli.motion.sample import sample
from fbfcli.plant.model import BA
from fbfcli.verify.contour_error import ErrorTally, contour_error, reach
from fbfcli.verify.held_back import HeldBack, Ready
from fbfcli.verify.simulate import Coupling, Nozzle

STRIDE = 4  # samples between those whose contour error is measured


@dataclass(frozen=True)
class Stretches:
    """Samples of stretches that have been written. n samples, s stretches, k segments.

    begin, end : ndarray of int, shape (s,)        first and last sample of each
    rest       : ndarray of int, shape (s,)        samples of rest before each
    begun      : bool                              the first goes on from before; sample 0 was the last one then
    goes_on    : bool                              the last stretch goes on in the next ones
    desired, command : ndarray, shape (n, 2)       [mm]
    extruding  : ndarray of bool, shape (n,)
    line       : ndarray of int, shape (n,)        line of the file that asks for each sample, counted from 0
    first      : ndarray of int, shape (s,)        first segment of each
    start, delta : ndarray, shape (k, 4)           segments as written [mm]
    distance   : ndarray, shape (k,)
    wanted     : ndarray, shape (k,)               time each should last [s]
    executed   : Profile                           what the planner model makes of them
    late       : float                             how late the first starts [s]
    dt         : float
    place      : ndarray of int, shape (n,)        where the print is; None: the plants hold everywhere
    filament   : ndarray, shape (n,)               E as sliced [mm]; None: that of the segments
    """

    begin: np.ndarray
    end: np.ndarray
    rest: np.ndarray
    begun: bool
    goes_on: bool
    desired: np.ndarray
    command: np.ndarray
    extruding: np.ndarray
    line: np.ndarray
    first: np.ndarray
    start: np.ndarray
    delta: np.ndarray
    distance: np.ndarray
    wanted: np.ndarray
    executed: Profile
    late: float
    dt: float
    place: np.ndarray | None = None
    filament: np.ndarray | None = None

    def positions(self, columns: slice = slice(2)) -> np.ndarray:
        """What the planner model executes, on the samples, shape (n, k): X and Y, or these of X Y Z E."""
        t0 = self.starts()
        start, delta = self.start[:, columns], self.delta[:, columns]
        x, _ = sample(start, delta, self.distance, self.executed, t0, len(self.desired), self.dt)
        new = slice(1 if self.begun else 0, None)
        x[self.begin[new]] = start[self.first[new]]
        return x

    def finer(self, times: int) -> Stretches:
        """The same on samples `times` closer: what is executed is known in between, the rest is linear, or holds on."""
        if times == 1:
            return self
        length = times * (self.end - self.begin)
        begin = np.cumsum(length + 1) - length - 1
        after = np.arange(length.sum() + len(length)) - np.repeat(begin, length + 1)
        old = np.repeat(self.begin, length + 1) + after // times
        part = after % times / times
        following = np.minimum(old + 1, len(self.desired) - 1)

        def linear(x: np.ndarray) -> np.ndarray:
            return x[old] + (part if x.ndim == 1 else part[:, None]) * (x[following] - x[old])

        return replace(
            self,
            begin=begin,
            end=begin + length,
            rest=times * self.rest,
            desired=linear(self.desired),
            command=linear(self.command),
            extruding=self.extruding[old],
            line=self.line[old],
            dt=self.dt / times,
            place=None if self.place is None else self.place[old],
            filament=None if self.filament is None else linear(self.filament),
        )

    def starts(self) -> np.ndarray:
        """When each segment begins as it is executed, from sample 0 on, shape (k,) [s]."""
        t0 = self._starting(self.executed.duration)
        if self.begun:
            t0[: self.counts[0]] += self.late
        return t0

    def polyline(self) -> np.ndarray:
        """X and Y that the written segments stand for: each at constant speed, in its wanted time, shape (n, 2)."""
        start, last = self.start[:, :2], np.cumsum(self.counts) - 1
        node = np.rint(self._starting(self.wanted) / self.dt).astype(np.int64)
        hats = Polyline(np.insert(node, last + 1, self.end), np.zeros(len(node) + len(last), dtype=bool))
        values = np.insert(start, last + 1, start[last] + self.delta[last, :2], axis=0)
        return np.column_stack([hats.curve(values[:, axis]) for axis in range(2)])

    @property
    def counts(self) -> np.ndarray:
        """Segments of each stretch."""
        return np.diff(np.append(self.first, len(self.distance)))

    def _starting(self, duration: np.ndarray) -> np.ndarray:
        """When each segment begins if each stretch does so on time, shape (k,) [s]."""
        elapsed = np.cumsum(duration) - duration
        return elapsed + np.repeat(self.begin * self.dt - elapsed[self.first], self.counts)


class Tally:
    """What the written file does on the printer's own model, so far.

    plants : (b, a) of X and Y, or what gives them for a place
    coupling : what the other axis' command adds to X and to Y, as of `Nozzle`
    watch  : told of everything that is added
    follow, chord : what is executed against the polyline that is written, and that against the command
    before, after : errors of the nozzle uncompensated and compensated
    """

    def __init__(
        self,
        plants: Sequence[BA] | Callable[[int], Sequence[BA]],
        watch: Callable[[Stretches], None] = lambda part: None,
        coupling: Coupling = (None, None),
    ):
        self._watch = watch
        self._uncompensated, self._compensated = Nozzle(plants, coupling), Nozzle(plants, coupling)
        self._held: HeldBack | None = None
        self.follow, self.chord, self.before, self.after = (ErrorTally() for _ in range(4))
        self.segments = 0
        self.wanted_s = self.executed_s = 0.0
        self.busiest = 0  # segments within one second
        self._second, self._in_second = 0, 0  # of compensated motion, and segments in it so far

    def add(self, part: Stretches) -> None:
        """Execute the written segments, drive the plant, and count the errors."""
        self._watch(part)
        self.segments += len(part.distance)
        self.wanted_s += float(part.wanted.sum())
        self.executed_s += float(part.executed.duration.sum())
        self._count_seconds(part.wanted)
        x, polyline = part.positions(), part.polyline()
        new = slice(1 if part.begun else 0, None)
        self.follow.add(_distance(x[new], polyline[new]))
        self.chord.add(_distance(polyline[new], part.command[new]))
        begin, rest = (part.begin[1:] - 1, part.rest[1:]) if part.begun else (part.begin, part.rest)
        place = None if part.place is None else part.place[new]
        before = self._uncompensated.follow(part.desired[new], begin, rest, place)
        after = self._compensated.follow(x[new], begin, rest, place)
        self._held = self._held or HeldBack(reach(part.dt))
        rows = (part.desired[new], before, after, part.extruding[new])
        self._contour(self._held.add(rows, begin, part.goes_on), part.dt)

    def _count_seconds(self, wanted: np.ndarray) -> None:
        """Most segments that begin within one second of compensated motion."""
        second = (self.wanted_s - wanted.sum() + np.cumsum(wanted) - wanted).astype(np.int64)
        counts = np.bincount(second - self._second)
        counts[0] += self._in_second
        self._second, self._in_second = int(second[-1]), int(counts[-1])
        self.busiest = max(self.busiest, int(counts.max()))

    def _contour(self, ready: Ready, dt: float) -> None:
        """Count contour errors of samples that print."""
        desired, before, after, extruding = ready.rows
        at = np.arange(ready.at.start, ready.at.stop)[extruding[ready.at]][::STRIDE]
        first, last = ready.stretch(at)
        self.before.add(contour_error(before, desired, at, first, last, dt))
        self.after.add(contour_error(after, desired, at, first, last, dt))

    @property
    def drift_ppm(self) -> float:
        """How much longer the written file takes than it should, in parts per million."""
        return 1e6 * (self.executed_s / self.wanted_s - 1.0) if self.wanted_s else 0.0

    @property
    def rate(self) -> float:
        """Segments per second of compensated motion."""
        return self.segments / self.wanted_s if self.wanted_s else 0.0


def _distance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Between points of the same sample, shape (n,)."""
    x, y = a[:, 0] - b[:, 0], a[:, 1] - b[:, 1]
    return np.sqrt(x * x + y * y)
