"""What is executed, as the machine will be asked to draw it: of a compensated file, and of a file as it is written.

Both know the line, the layer and the feature of each sample. A file as it is written is planned anew: its motion is
known at any time. Of a compensated one, segments are executed at any time, and what is desired is linear in between the
samples of the trajectory, as the command is.
"""

from __future__ import annotations

import numpy as np

from fbfcli.gcode.marks import Marks
from fbfcli.motion.moves import E, X, Y, Z
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.timeline import Track
from fbfcli.verify.execution import Execution
from fbfcli.verify.input_shaping import NO_PLAN, InputShaping, Plan
from fbfcli.verify.tally import Stretches

STANDS_MM = 1e-9  # a sample's way of X and Y below which the machine stands


class Executions:
    """The executions of one file, which comes in stretches or in tracks.

    marks   : of the file, told of its text before its motion comes here
    machine : tells where on the machine the print is
    dt      : period [s]
    shaping : the firmware's, of tracks; None: it has none
    starts  : when the segments of the last stretches began, shape (k,) [s]
    """

    def __init__(self, marks: Marks, machine: Designs, dt: float, shaping: InputShaping | None = None):
        self._marks, self._machine, self._dt, self._shaping = marks, machine, dt, shaping
        self._tick = 0  # of the last sample
        self._x: np.ndarray | None = None  # where the last track ended
        self._given: Plan | None = None  # the last sample given out
        self._was = np.zeros(2)  # what X and Y were set by so far
        self.starts = np.zeros(0)

    def of_stretches(self, part: Stretches) -> Execution:
        """What the firmware makes of the text that was written for these stretches."""
        fine = part.finer(round(part.dt / self._dt))
        new = 1 if part.begun else 0  # sample 0 was the last one before
        motion, begin, rest = fine.positions(slice(4))[new:], fine.begin[new:] - new, fine.rest[new:]
        passed = np.ones(len(motion), dtype=np.int64)
        passed[begin] = rest
        tick = self._tick + np.cumsum(passed)
        opened = np.append([self._tick] * new, tick[begin])
        self.starts = part.starts() + np.repeat(opened * self._dt - part.begin * part.dt, part.counts)
        self._tick = int(tick[-1])
        paths = fine.desired[new:], fine.command[new:], motion
        filament = None if fine.filament is None else fine.filament[new:]
        return self._execution(tick, fine.line[new:], begin, rest, part.goes_on, fine.extruding[new:], paths, filament)

    def of_track(self, track: Track) -> Execution | None:
        """A file as it is written: the firmware does what is asked of it. None: nothing is final yet."""
        if not len(track):
            return None
        before = np.concatenate([track.x[:1] if self._x is None else self._x[None], track.x[:-1]])
        was = np.zeros((len(track), 2))
        was[track.jump] = (track.x - before)[track.jump, :2]
        was = self._was + np.cumsum(was, axis=0)
        self._x, self._was = track.x[-1], was[-1]
        return self._planned(Plan(track.tick, track.x, was, track.line), last=False)

    def finish(self) -> Execution | None:
        """What is left of a file as it is written; None: nothing."""
        return self._planned(NO_PLAN, last=True) if self._shaping and self._x is not None else None

    def _planned(self, plan: Plan, last: bool) -> Execution | None:
        """Across a rest, and where the machine is set, a stretch begins."""
        u = plan.x[:, :2]
        if self._shaping:
            plan, u = self._shaping.push(plan, last)
        if not len(plan):
            return None
        first = self._given is None
        before = plan[:1] if self._given is None else self._given
        passed = np.diff(plan.tick, prepend=before.tick)
        opens = (passed > 1) | (np.diff(plan.was, axis=0, prepend=before.was) != 0.0).any(axis=1)
        opens[0] |= first
        step = np.diff(plan.x[:, [X, Y, E]], axis=0, prepend=before.x[:, [X, Y, E]])
        extruding = (np.abs(step[:, :2]).max(axis=1) > STANDS_MM) & (step[:, 2] > 0.0)
        begin = np.flatnonzero(opens)
        rest = np.maximum(passed[begin] - 1, 0)
        self._given = plan[-1:]
        motion = np.column_stack([u, plan.x[:, Z:]])
        return self._execution(plan.tick, plan.line, begin, rest, True, extruding, (plan.x[:, :2], u, motion))

    def _execution(
        self,
        tick: np.ndarray,
        line: np.ndarray,
        begin: np.ndarray,
        rest: np.ndarray,
        goes_on: bool,
        extruding: np.ndarray,
        paths: tuple[np.ndarray, np.ndarray, np.ndarray],
        filament: np.ndarray | None = None,
    ) -> Execution:
        """An execution, with what the file's marks and the machine's places say; paths: desired, command and motion."""
        desired, command, motion = paths
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
            filament=filament,
        )
