"""The order of the steps: text, moves, plan, trajectory, command, motor positions, pulses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np

from fbfcli.errors import LimitError
from fbfcli.motion.kinematics import Kinematics, kinematics_of
from fbfcli.pipeline.commander import Commander
from fbfcli.pipeline.compensate import box_of, check_ceilings, compensator_of, plants_of
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.settings import Settings
from fbfcli.pipeline.summary import clock
from fbfcli.pipeline.timeline import Event, Timeline, Track
from fbfcli.printer import Printer
from fbfcli.steps.driver_inputs import Inputs, TooFast
from fbfcli.steps.pulses import Motor
from fbfcli.steps.stream import Motors, MotorSteps, Piece, Steps
from fbfcli.units import NS_PER_S

AS_WRITTEN = "none"  # the method that changes nothing: the firmware's own plan
ROWS = 4096  # samples turned into steps at a time: bounds the memory
NO_E = "E makes no steps: the profile has no steps_per_mm under [axis.e]"


@dataclass(frozen=True)
class MotorTold:
    """One motor of a stream: steps in all, where it ends [steps from position 0], the highest rate [steps/s]."""

    name: str
    steps_per_mm: float
    steps: int
    end: int
    peak_rate: float


@dataclass(frozen=True)
class StepsSummary:
    """Figures of one step stream; `time` [s]."""

    printer: str
    kinematics: str
    method: str
    time: float
    lines: int
    moves: int
    motors: tuple[MotorTold, ...]
    events: int
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        return asdict(self)

    def text(self) -> str:
        """For people, on stderr."""
        total = sum(one.steps for one in self.motors)
        rows = [("print time", clock(self.time)), ("steps", f"{total:,} in all, {self.events:,} events beside them")]
        rows += [
            (f"motor {one.name}", f"{one.steps:,} steps, at most {one.peak_rate:,.0f}/s, ends at {one.end:,}")
            for one in self.motors
        ]
        told = [f"{name + ':':15s}{value}" for name, value in rows]
        return "\n".join([*told, *(f"warning: {warning}" for warning in self.warnings)])


def motors_of(printer: Printer) -> Motors:
    """Names and steps per mm of the motors that make steps. Raises ProfileError."""
    names: tuple[str, ...] = kinematics_of(printer).names
    rates = tuple(axis.steps_per_mm for axis in printer.axes)
    if printer.e_steps_per_mm is not None:
        names, rates = (*names, "e"), (*rates, printer.e_steps_per_mm)
    return Motors(names, rates)


class StepStream:
    """One file as a stream of steps: iterate over `pieces`, then ask for the `summary`."""

    def __init__(self, printer: Printer, settings: Settings):
        self._printer, self._settings = printer, settings
        self.motors = motors_of(printer)
        self._kinematics = kinematics_of(printer)
        self._timeline = Timeline(settings.dt)
        self._reader = Reader(printer, settings, as_written=settings.method == AS_WRITTEN)
        self._commander = self._command()
        self._drive = _Drive(printer, self.motors, self._kinematics, settings.dt)
        self._events = 0

    def _command(self) -> Commander | None:
        if self._settings.method == AS_WRITTEN:
            return None
        check_ceilings(self._printer, self._settings)
        compensator = compensator_of(plants_of(self._printer, self._settings.dt), self._settings)
        return Commander(compensator, box_of(self._printer), self._settings.dt)

    def pieces(
        self, chunks: Iterable[bytes], progress: Callable[[int], None] = lambda done: None
    ) -> Iterator[tuple[Piece, Sequence[Event]]]:
        """The stream, and the events of about the same time. Raises GcodeError (without the file's name), LimitError.

        chunks   : the file's text, whole lines
        progress : told how many bytes of it have been read
        """
        for portion in self._reader.portions(chunks, progress):
            batch = self._commander.batch(portion.part, portion.inside) if self._commander else None
            track, events = self._timeline.part(portion.part, portion.inside, batch, portion.lines)
            self._events += len(events)
            cuts = [*range(0, len(track), ROWS), len(track)]
            for a, b in pairwise(cuts):
                yield self._drive.piece(track[a:b], last=False), events
                events = []
            if events:
                yield self._drive.piece(track[:0], last=False), events
        yield self._drive.rest(self._timeline.time), []

    @property
    def summary(self) -> StepsSummary:
        """Of what has been streamed so far."""
        return StepsSummary(
            printer=self._printer.name,
            kinematics=self._printer.kinematics,
            method=self._settings.method,
            time=self._timeline.time,
            lines=self._reader.count,
            moves=self._reader.moves,
            motors=self._drive.told(),
            events=self._events,
            warnings=self._warnings(),
        )

    def _warnings(self) -> tuple[str, ...]:
        told = list(self._reader.warnings)
        if self._printer.e_steps_per_mm is None:
            told.append(NO_E)
        if sets := self._timeline.sets:
            told.append(f"the machine was set to another position {len(sets)} times, first before line {sets[0]}")
        return tuple(told)


class _Drive:
    """The motors of one file."""

    def __init__(self, printer: Printer, motors: Motors, kinematics: Kinematics, dt: float):
        self._names, self._kinematics, self._dt = motors.names, kinematics, dt
        self._motors = [Motor(rate, printer.driver.hysteresis, dt) for rate in motors.steps_per_mm]
        self._inputs = [Inputs(printer.driver) for _ in motors.names]
        self._told = [0] * len(motors.names)
        self._rates, self._most = motors.steps_per_mm, printer.driver.max_step_rate
        self._end = 0  # ns, of the last piece
        self._lines = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))  # ticks and lines of late samples

    def piece(self, track: Track, last: bool) -> Piece:
        """Steps that are final with more of the track. Raises LimitError."""
        q = self._kinematics.motors(track.x[:, :3])
        if np.isnan(q).any():
            i = int(np.flatnonzero(np.isnan(q).any(axis=1))[0])
            x, y, z = track.x[i, :3].tolist()
            raise LimitError(
                f"line {track.line[i] + 1}: X{x:.3f} Y{y:.3f} Z{z:.3f} is out of the arms' reach "
                "(check delta_radius and arm_length, or move the part to the middle)"
            )
        q = np.column_stack([q, track.x[:, 3]])[:, : len(self._names)]
        self._lines = tuple(np.concatenate([old[-4:], new]) for old, new in zip(self._lines, (track.tick, track.line)))
        steps = [
            self._taken(i, motor.push(track.tick, q[:, i], track.jump, last)) for i, motor in enumerate(self._motors)
        ]
        begin, ticks = self._end, self._lines[0]
        if len(ticks) > 1:
            self._end = round(int(ticks[-2]) * self._dt * NS_PER_S)
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
            ticks, lines = self._lines
            line = lines[min(np.searchsorted(ticks, taken.time / NS_PER_S / self._dt), len(lines) - 1)] + 1
            raise LimitError(
                f"line {line}: at {taken.time / NS_PER_S:.6f} s motor {self._names[i]} would make {taken.rate:,.0f} "
                f"steps/s, more than max_step_rate = {self._most:,.0f} of its driver (print slower: --velocity, or "
                "use fewer microsteps)"
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
