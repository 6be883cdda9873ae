"""A machine that draws a print piece by piece: its nozzle, and its errors at every sample."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np

from fbfcli.plant.model import BA
from fbfcli.verify.contour_error import contour_error, reach
from fbfcli.verify.execution import Execution
from fbfcli.verify.heading import Heading, along_and_across
from fbfcli.verify.held_back import HeldBack, Ready
from fbfcli.verify.passage import Passage
from fbfcli.verify.simulate import Coupling, Nozzle

NOT_ROWS = ("dt", "begin", "rest", "goes_on")  # of an execution
NO_BEGIN = -1  # in the column that says how long a rest there is before a stretch


class Passages:
    """What one machine makes of an execution that comes in pieces.

    plants   : (b, a) of X and Y, or what gives them for a place
    coupling : what the other axis' command adds to X and to Y, as of `Nozzle`

    Its pieces are cut elsewhere: samples near a cut are held back until there is path on both sides of them.
    """

    def __init__(self, plants: Sequence[BA] | Callable[[int], Sequence[BA]], coupling: Coupling = (None, None)):
        self._nozzle = Nozzle(plants, coupling)
        self._held: HeldBack | None = None
        self._heading: Heading | None = None
        self._names: tuple[str, ...] = ()  # of the columns
        self._dt = 0.0

    def add(self, execution: Execution) -> Passage | None:
        """What is final with more of the execution; None: nothing yet."""
        if not len(execution):
            return None
        if self._held is None or self._heading is None:
            self._dt = execution.dt
            self._held, self._heading = HeldBack(reach(self._dt)), Heading(self._dt)
            self._names = tuple(name for name in _columns() if getattr(execution, name) is not None)
        opens = np.full(len(execution), NO_BEGIN, dtype=np.int64)
        opens[execution.begin] = execution.rest
        begin = execution.begin
        nozzle = self._nozzle.follow(execution.motion[:, :2], begin, execution.rest, execution.place)
        heading = self._heading.follow(execution.desired, begin)
        rows = (nozzle, heading, opens, *(getattr(execution, name) for name in self._names))
        return self._passage(self._held.add(rows, begin, execution.goes_on), execution.goes_on)

    def finish(self) -> Passage | None:
        """What is still held back; no more will come."""
        rest = self._held.rest() if self._held else None
        return self._passage(rest, goes_on=False) if rest else None

    def _passage(self, ready: Ready, goes_on: bool) -> Passage | None:
        at = np.arange(ready.at.start, ready.at.stop)
        if not len(at):
            return None
        all_nozzle, all_desired = ready.rows[0], ready.rows[3 + self._names.index("desired")]
        contour = contour_error(all_nozzle, all_desired, at, *ready.stretch(at), self._dt)
        nozzle, heading, opens, *columns = (column[ready.at] for column in ready.rows)
        rows = dict(zip(self._names, columns, strict=True))
        begin = np.flatnonzero(opens != NO_BEGIN)
        open_last = goes_on and not (ready.begin == ready.at.stop).any()  # else all that is held back is a new stretch
        error = nozzle - rows["desired"]
        along, across = along_and_across(error, heading)
        return Passage(
            execution=Execution(dt=self._dt, begin=begin, rest=opens[begin], goes_on=open_last, **rows),
            nozzle=nozzle,
            tracking=np.hypot(error[:, 0], error[:, 1]),
            contour=contour,
            across=across,
            along=along,
        )


def _columns() -> tuple[str, ...]:
    return tuple(field.name for field in fields(Execution) if field.name not in NOT_ROWS)
