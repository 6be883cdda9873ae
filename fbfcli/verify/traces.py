"""What pictures of a print need, kept in bounded memory while it streams past."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from fbfcli.plant.frf import Frf, frf
from fbfcli.plant.spectra import Spectra, together, welch
from fbfcli.verify.close_ups import CloseUp, CloseUps
from fbfcli.verify.envelope import Envelope, Enveloped
from fbfcli.verify.execution import Execution
from fbfcli.verify.layer_paths import Layer, LayerPaths, Thinning
from fbfcli.verify.passage import Passage

T = TypeVar("T")
POINTS = 300_000  # of all paths: 6 MB of a page
CORNERS = 16  # of the first method, half as many of each other one
TOGETHER = 65_536  # samples that are looked at at once
WINDOW_S = 1.0  # of spectra
HIGHEST_HZ = 200.0
AVERAGES = 400.0  # windows after which a response is known well enough


@dataclass(frozen=True)
class Method:
    """The curves of one method over time and frequency.

    seconds  : how long its print lasts [s]
    error    : Envelope        distance of the nozzle from the desired path where it draws [mm]
    moves    : Envelope        X and Y of the command: speed, then acceleration, four curves [mm/s], [mm/s^2]
    asked    : (Frf, Frf)      of X and Y: command over desired; None where too little moves
    reached  : (Frf, Frf)      nozzle over desired
    segments : Envelope        written segments per second; None where nobody said
    load     : Envelope        of each motor: share of the torque it has; None where nobody said
    motors   : their names
    """

    seconds: float
    error: Envelope
    moves: Envelope
    asked: tuple[Frf | None, Frf | None]
    reached: tuple[Frf | None, Frf | None]
    segments: Envelope | None
    load: Envelope | None
    motors: tuple[str, ...]


@dataclass(frozen=True)
class Kept:
    """What was kept of a print: nouns for pictures. The first method is what the others are compared with."""

    methods: dict[str, Method]
    layers: tuple[Layer, ...]
    corners: tuple[CloseUp, ...]
    thinning: Thinning

    def renamed(self, names: Mapping[str, str]) -> Kept:
        """The same with other names of the methods."""

        def under(old: dict[str, T]) -> dict[str, T]:
            return {names.get(name, name): each for name, each in old.items()}

        layers = tuple(replace(layer, nozzle=under(layer.nozzle)) for layer in self.layers)
        corners = tuple(
            replace(corner, method=names.get(corner.method, corner.method), windows=under(corner.windows))
            for corner in self.corners
        )
        return replace(self, methods=under(self.methods), layers=layers, corners=corners)


class Traces:
    """Collects the passages of one or several methods, one after the other or by turns.

    points  : of all thinned paths together
    corners : of the first method that are kept in full resolution, half as many of each other one

    Where a print has extruded nothing yet, every move draws: plotters and mills never extrude.
    """

    def __init__(self, points: int = POINTS, corners: int = CORNERS):
        self._paths, self._corners = LayerPaths(points), CloseUps(corners)
        self._curves: dict[str, _Curves] = {}
        self._extrudes: set[str] = set()
        self._dt = 0.0

    def begin(self, name: str, features: Sequence[str]) -> None:
        """A method begins; what the features are called is told with the figures."""
        self._curves.setdefault(name, _Curves())

    def add(self, name: str, passage: Passage) -> None:
        """More of what the machine makes of a method."""
        for first in range(0, len(passage), TOGETHER):
            self._add(name, passage[first : first + TOGETHER])

    def _add(self, name: str, passage: Passage) -> None:
        execution = passage.execution
        curves = self._curves.setdefault(name, _Curves())
        first = name == next(iter(self._curves))
        drawn = execution.extruding
        if name not in self._extrudes and drawn.any():
            self._extrudes.add(name)
            self._paths.forget(name, first)
            self._corners.forget(name)
        if name not in self._extrudes:
            drawn = np.ones(len(passage), dtype=bool)
        self._paths.add(name, passage, drawn, first)
        self._corners.add(name, passage, drawn)
        curves.add(passage, drawn)
        self._dt = execution.dt

    def segments(self, name: str, starts: np.ndarray) -> None:
        """More written segments: when each begins, shape (k,), since the print began [s]."""
        self._curves.setdefault(name, _Curves()).count(starts)

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        """More of the motors' loads: share (n, m) of the torque that each of m motors has, at time (n,) [s]."""
        self._curves.setdefault(name, _Curves()).carry(time, share, tuple(motors))

    def kept(self) -> Kept:
        """What there is to see of all that was added."""
        if self._dt:
            self._corners.finish(self._dt)
        methods = {name: curves.method() for name, curves in self._curves.items()}
        return Kept(methods, self._paths.layers(), self._corners.corners(), self._paths.thinning())


class _Curves:
    """One method's curves over time and frequency."""

    def __init__(self) -> None:
        self._error, self._moves = Enveloped(1), Enveloped(4)
        self._asked, self._reached = _Responses(), _Responses()
        self._seconds = 0.0
        self._segments: Enveloped | None = None
        self._second, self._in_second = 0, 0
        self._load: Enveloped | None = None
        self._motors: tuple[str, ...] = ()
        self._tail = np.zeros((0, 2))  # the last two commands of a stretch that goes on

    def add(self, passage: Passage, drawn: np.ndarray) -> None:
        e = passage.execution
        self._seconds = float(e.time[-1])
        self._error.add(e.time[drawn], passage.contour[drawn, None])
        self._moves.add(e.time, self._derived(e))
        self._asked.add(e, e.command)
        self._reached.add(e, passage.nozzle)

    def count(self, starts: np.ndarray) -> None:
        """Segments in each whole second."""
        self._segments = self._segments or Enveloped(1, 1.0)
        if not len(starts):
            return
        second = starts.astype(np.int64)
        if second[0] > self._second:
            self._tell_second(np.array([self._second]), np.array([self._in_second]))
            self._in_second = 0
        self._second = max(self._second, int(second[0]))
        counts = np.bincount(np.maximum(second - self._second, 0))
        counts[0] += self._in_second
        whole = np.flatnonzero(counts[:-1])
        self._tell_second(self._second + whole, counts[whole])
        self._second, self._in_second = self._second + len(counts) - 1, int(counts[-1])

    def _tell_second(self, second: np.ndarray, count: np.ndarray) -> None:
        assert self._segments is not None
        self._segments.add(second[count > 0] + 0.5, count[count > 0, None].astype(float))

    def carry(self, time: np.ndarray, share: np.ndarray, motors: tuple[str, ...]) -> None:
        self._load = self._load or Enveloped(len(motors))
        self._motors = motors
        self._load.add(time, share)

    def method(self) -> Method:
        if self._segments is not None and self._in_second:
            self._tell_second(np.array([self._second]), np.array([self._in_second]))
            self._in_second = 0
        return Method(
            self._seconds, self._error.envelope(), self._moves.envelope(), self._asked.responses(),
            self._reached.responses(), self._segments.envelope() if self._segments else None,
            self._load.envelope() if self._load else None, self._motors,
        )  # fmt: skip

    def _derived(self, e: Execution) -> np.ndarray:
        """Speed and acceleration of the command along X and Y, shape (n, 4); at rest where a stretch begins."""
        before = self._tail if len(self._tail) else np.repeat(e.command[:1], 2, axis=0)
        u = np.concatenate([before, e.command])
        v = np.diff(u, axis=0) / e.dt
        v[e.begin + 1] = 0.0  # what lies between stretches is no part of the command
        a = np.diff(v, axis=0) / e.dt
        a[e.begin] = 0.0
        self._tail = np.column_stack([e.command[-1] - v[-1] * e.dt, e.command[-1]]).T
        return np.column_stack([v[1:], a])


class _Responses:
    """The response of X and of Y to the desired motion, from as much of the print as it takes to know it."""

    def __init__(self) -> None:
        self._spectra: list[Spectra | None] = [None, None]

    def add(self, e: Execution, y: np.ndarray) -> None:
        """Accelerations of a stretch against those that are desired."""
        size = round(WINDOW_S / e.dt)
        cuts = np.concatenate([[0], e.begin[e.begin > 0], [len(e)]])
        for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
            if b - a < size + 2:
                continue
            for axis in range(2):
                known = self._spectra[axis]
                if known is not None and known.count.min() > AVERAGES:
                    continue
                x = np.diff(e.desired[a:b, axis], 2) / e.dt**2
                if x.any():
                    new = welch(x, np.diff(y[a:b, axis], 2) / e.dt**2, 1 / e.dt, (1.0, HIGHEST_HZ), WINDOW_S)
                    self._spectra[axis] = new if known is None else together([known, new])

    def responses(self) -> tuple[Frf | None, Frf | None]:
        x, y = (None if each is None else frf(each) for each in self._spectra)
        return x, y
