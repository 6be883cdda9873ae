"""One method's curves over time and over frequency, collected while its print streams past."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.frf import Frf, frf
from fbfcli.plant.spectra import Spectra, together, welch
from fbfcli.verify.envelope import Envelope, Enveloped
from fbfcli.verify.execution import Execution
from fbfcli.verify.passage import Passage

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


class Curves:
    """Collects them."""

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
        """More of the print; `drawn`, bool, (n,): samples whose errors count."""
        e = passage.execution
        self._seconds = float(e.time[-1])
        self._error.add(e.time[drawn], passage.contour[drawn, None])
        self._moves.add(e.time, self._derived(e))
        self._asked.add(e, e.command)
        self._reached.add(e, passage.nozzle)

    def count(self, starts: np.ndarray) -> None:
        """More written segments, by when they begin, shape (k,) [s]: counted in each whole second."""
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
        """Loads (n, m) of m motors at times (n,) [s], as shares of what they have."""
        self._load = self._load or Enveloped(len(motors))
        self._motors = motors
        self._load.add(time, share)

    def method(self) -> Method:
        """All of them; no more will come."""
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
