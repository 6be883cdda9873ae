"""What is executed, as the machine will be asked to draw it: of a compensated file, and of a file as it is written.

Both are sampled `rate` times a second and know the line, the layer and the feature of each sample.
"""

from __future__ import annotations

import numpy as np

from fbfcli.gcode.marks import Marks
from fbfcli.motion.moves import E, Z
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.timeline import Track
from fbfcli.verify.execution import Execution
from fbfcli.verify.tally import Stretches

STANDS_MM = 1e-9  # a sample's way of X and Y below which the machine stands


class Executions:
    """The executions of one file, whichever way it comes.

    marks   : of the file, told of its text before its motion comes here
    machine : tells where on the machine the print is
    dt      : period [s]
    """

    def __init__(self, marks: Marks, machine: Designs, dt: float):
        self._marks, self._machine, self._dt = marks, machine, dt
        self._tick = 0  # of the last sample
        self._xye = np.zeros(3)  # there, as written
        self._begun = False

    @property
    def time(self) -> float:
        """Of the last sample [s]."""
        return self._tick * self._dt

    def of_stretches(self, part: Stretches) -> Execution:
        """What the firmware makes of the text that was written for these stretches."""
        part = part.finer(round(part.dt / self._dt))
        new = 1 if part.begun else 0  # sample 0 was the last one before
        motion = part.positions(slice(4))[new:]
        begin, rest = part.begin[new:] - new, part.rest[new:]
        tick = self._ticks(len(motion), begin, rest)
        return self._execution(
            tick, begin, rest, part.goes_on, part.line[new:], motion, part.extruding[new:], part.desired[new:],
            part.command[new:]
        )  # fmt: skip

    def of_track(self, track: Track) -> Execution:
        """A file as it is written: the firmware does what is asked of it. Where the machine is set, a stretch begins."""
        passed = np.diff(track.tick, prepend=self._tick if self._begun else track.tick[:1] - 1)
        opens = passed > 1
        opens[track.jump] = True
        opens[:1] |= not self._begun
        begin = np.flatnonzero(opens)
        step = np.diff(track.x[:, [0, 1, E]], axis=0, prepend=self._xye[None] if self._begun else track.x[:1, [0, 1, E]])
        extruding = (np.abs(step[:, :2]).max(axis=1) > STANDS_MM) & (step[:, 2] > 0.0)
        self._xye, self._tick, self._begun = track.x[-1, [0, 1, E]], int(track.tick[-1]), True
        return self._execution(
            track.tick, begin, passed[begin] - 1, True, track.line, track.x, extruding, track.x[:, :2], track.x[:, :2]
        )

    def _ticks(self, count: int, begin: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """When each sample comes: one period after the other; a stretch begins when the rest before it is over."""
        passed = np.ones(count, dtype=np.int64)
        passed[begin] = rest
        tick = self._tick + np.cumsum(passed)
        self._tick = int(tick[-1])
        return tick

    def _execution(
        self,
        tick: np.ndarray,
        begin: np.ndarray,
        rest: np.ndarray,
        goes_on: bool,
        line: np.ndarray,
        motion: np.ndarray,
        extruding: np.ndarray,
        desired: np.ndarray,
        command: np.ndarray,
    ) -> Execution:
        self._marks.heights(line[extruding], motion[extruding, Z])
        return Execution(
            dt=self._dt,
            begin=begin,
            rest=rest,
            goes_on=goes_on,
            time=tick * self._dt,
            line=line,
            layer=self._marks.layer(line),
            feature=self._marks.feature(line),
            desired=desired,
            command=command,
            motion=motion,
            extruding=extruding,
            place=self._machine.places(motion) if self._machine.vary else None,
        )
