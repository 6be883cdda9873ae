"""One print as a machine draws it: under every condition, with its motors, for those who watch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fbfcli.gcode.marks import Marks
from fbfcli.motion.moves import E, Z
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.executions import Executions
from fbfcli.pipeline.machine import Condition, plants_of
from fbfcli.pipeline.settings import AS_WRITTEN, Settings
from fbfcli.pipeline.timeline import Track
from fbfcli.pipeline.watcher import Watcher
from fbfcli.plant.coupling import coupling
from fbfcli.printer import Printer
from fbfcli.verify.account import Account, Accounted
from fbfcli.verify.execution import Execution
from fbfcli.verify.input_shaping import InputShaping
from fbfcli.verify.motors_told import MotorsTold
from fbfcli.verify.passage import Passage
from fbfcli.verify.passages import Passages
from fbfcli.verify.stepper import Motors
from fbfcli.verify.tally import Stretches


class Drawing:
    """Fed with what the firmware does, in order.

    name    : told to the watchers
    shaping : the firmware's, of tracks; None: it has none
    like    : of another method, ahead of this one or in step with it: the same walls are shown
    marks   : to be told of the file's text before its motion comes here
    """

    def __init__(
        self,
        name: str,
        machine: Printer,
        under: Sequence[Condition],
        dt: float,
        watchers: Sequence[Watcher],
        shaping: InputShaping | None = None,
        like: Drawing | None = None,
    ):
        designs = Designs(machine, AS_WRITTEN, Settings(dt=dt))
        self._name, self._watchers = name, watchers
        self.marks = Marks()
        self._executions = Executions(self.marks, designs, dt, shaping)
        self._passages = [Passages(plants_of(designs, condition, dt), coupling(machine, dt)) for condition in under]
        others: Sequence[Account | None] = like._accounts if like else [None] * len(under)
        self._accounts: list[Account] = [Account(self.marks.features, other) for other in others]
        self._motors = Motors(machine, dt, watch=self._carry)
        self.begun = False  # there was something to draw, or all of it is drawn

    def stretches(self, part: Stretches) -> None:
        """More of a compensated file."""
        self._begin()
        execution = self._executions.of_stretches(part)
        for watcher in self._watchers:
            watcher.segments(self._name, self._executions.starts)
        self._draw(execution)

    def sliced(self, part: Stretches) -> None:
        """The same, were the machine asked for what is desired."""
        whole = self._executions.of_stretches(part)
        pushed = whole.motion[:, E] if whole.filament is None else whole.filament
        motion = np.column_stack([whole.desired, whole.motion[:, Z], pushed])
        self._draw(replace(whole, command=whole.desired, motion=motion, filament=None))

    def track(self, track: Track) -> None:
        """More of a file as it is written."""
        execution = self._executions.of_track(track)
        if execution is not None:
            self._draw(execution)

    def finish(self) -> tuple[tuple[Accounted, ...], MotorsTold]:
        """Errors under each condition, and what the motors did; no more will come."""
        self._begin()
        execution = self._executions.finish()
        if execution is not None:
            self._draw(execution)
        for i, passages in enumerate(self._passages):
            self._count(i, passages.finish())
            self._accounts[i].finish()
        return tuple(account.figures() for account in self._accounts), self._motors.figures()

    def _begin(self) -> None:
        """Tell the watchers, once: a method that turns out not to be for the model never begins."""
        if not self.begun:
            self.begun = True
            for watcher in self._watchers:
                watcher.begin(self._name, self.marks.features)

    def _draw(self, execution: Execution) -> None:
        self._begin()
        for i, passages in enumerate(self._passages):
            self._count(i, passages.add(execution))

    def _carry(self, time: np.ndarray, share: np.ndarray, names: Sequence[str]) -> None:
        for watcher in self._watchers:
            watcher.load(self._name, time, share, names)

    def _count(self, i: int, passage: Passage | None) -> None:
        """Count the errors under condition i; as modelled, the machine is watched, and its motors feel the load."""
        if passage is None:
            return
        self._accounts[i].add(passage)
        if i == 0:
            self._motors.add(passage)
            for watcher in self._watchers:
                watcher.add(self._name, passage)
