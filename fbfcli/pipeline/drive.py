"""The motors of one file: positions of the machine to their steps, as their drivers take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.errors import LimitError
from fbfcli.motion.kinematics import in_reach, kinematics_of
from fbfcli.pipeline.timeline import Track
from fbfcli.printer import Printer
from fbfcli.steps.driver_inputs import Inputs, TooFast
from fbfcli.steps.pulses import Motor
from fbfcli.steps.stream import Motors, MotorSteps, Piece, Steps
from fbfcli.units import NS_PER_S


@dataclass(frozen=True)
class MotorTold:
    """One motor of a stream: steps in all, where it ends [steps from position 0], the highest rate [steps/s]."""

    name: str
    steps_per_mm: float
    steps: int
    end: int
    peak_rate: float


def motors_of(printer: Printer) -> Motors:
    """Names and steps per mm of the motors that make steps. Raises ProfileError."""
    names: tuple[str, ...] = kinematics_of(printer).names
    rates = tuple(axis.steps_per_mm for axis in printer.axes)
    if printer.e_steps_per_mm is not None:
        names, rates = (*names, "e"), (*rates, printer.e_steps_per_mm)
    return Motors(names, rates)


class Drive:
    """The motors of one file."""

    def __init__(self, printer: Printer, motors: Motors, dt: float):
        self._names, self._kinematics, self._dt = motors.names, kinematics_of(printer), dt
        self._motors = [Motor(rate, printer.driver.hysteresis, dt) for rate in motors.steps_per_mm]
        self._inputs = [Inputs(printer.driver) for _ in motors.names]
        self._told = [0] * len(motors.names)
        self._rates, self._most = motors.steps_per_mm, printer.driver.max_step_rate
        self._end = 0  # ns, of the last piece
        self._ticks = self._lines = np.zeros(0, dtype=np.int64)  # of the last samples

    def piece(self, track: Track, last: bool) -> Piece:
        """Steps that are final with more of the track. Raises LimitError."""
        q = in_reach(self._kinematics, track.x[:, :3], track.line)
        q = np.column_stack([q, track.x[:, 3]])[:, : len(self._names)]
        self._ticks = np.concatenate([self._ticks[-4:], track.tick])
        self._lines = np.concatenate([self._lines[-4:], track.line])
        steps = [
            self._taken(i, motor.push(track.tick, q[:, i], track.jump, last)) for i, motor in enumerate(self._motors)
        ]
        begin = self._end
        if len(self._ticks) > 1:
            self._end = round(int(self._ticks[-2]) * self._dt * NS_PER_S)
        return Piece(Steps(begin, self._end, tuple(steps)), track.tick, q)

    def rest(self, time: float) -> Piece:
        """The last steps; the stream ends at `time` [s]."""
        nothing = np.zeros(0, dtype=np.int64)
        piece = self.piece(Track(nothing, np.zeros((0, 4)), nothing, nothing), last=True)
        last = max([int(one.time[-1]) for one in piece.steps.motors if len(one)], default=0)
        end = max(round(time * NS_PER_S), last)
        return Piece(Steps(piece.steps.begin, end, piece.steps.motors), piece.tick, piece.position)

    def _taken(self, i: int, steps: MotorSteps) -> MotorSteps:
        """The steps as the driver takes them."""
        taken = self._inputs[i].taking(steps)
        if isinstance(taken, TooFast):
            sample = int(np.searchsorted(self._ticks, taken.time / NS_PER_S / self._dt))
            line = self._lines[min(sample, len(self._lines) - 1)]
            raise LimitError(
                f"line {line + 1}: at {taken.time / NS_PER_S:.6f} s motor {self._names[i]} would make "
                f"{taken.rate:,.0f} steps/s, more than max_step_rate = {self._most:,.0f} of its driver "
                "(print slower: --velocity, or use fewer microsteps)"
            )
        self._told[i] += len(taken)
        return taken

    def told(self) -> tuple[MotorTold, ...]:
        """What each motor has done."""
        return tuple(
            MotorTold(name, rate, count, motor.taken, inputs.peak_rate)
            for name, rate, count, motor, inputs in zip(
                self._names, self._rates, self._told, self._motors, self._inputs, strict=True
            )
        )
