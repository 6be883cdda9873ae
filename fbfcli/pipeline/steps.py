"""The order of the steps: text, moves, plan, trajectory, command, motor positions, pulses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise

from fbfcli.pipeline.choice import Choice, chosen
from fbfcli.pipeline.commander import Commander
from fbfcli.pipeline.compensate import check_ceilings
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.drive import Drive, MotorTold, motors_of
from fbfcli.pipeline.filament import Filament
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.rows import told
from fbfcli.pipeline.settings import AS_WRITTEN, Settings
from fbfcli.pipeline.summary import clock
from fbfcli.pipeline.timeline import Event, Timeline
from fbfcli.printer import Printer
from fbfcli.steps.stream import Piece

ROWS = 4096  # samples turned into steps at a time: bounds the memory
NO_E = "E makes no steps: the profile has no steps_per_mm under [axis.e]"


@dataclass(frozen=True)
class StepsSummary:
    """Figures of one step stream; `time` [s]."""

    printer: str
    kinematics: str
    method: str
    why: str
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
        rows.append(("method", f"{self.method} ({self.why})" if self.why else self.method))
        return told(rows, self.warnings)


class StepStream:
    """One file as a stream of steps: iterate over `pieces`, then ask for the `summary`."""

    def __init__(self, printer: Printer, settings: Settings):
        check_ceilings(printer, settings)
        self._printer, self._settings = printer, settings
        self.motors = motors_of(printer)
        self._timeline = Timeline(settings.dt)
        self._reader = Reader(printer, settings, as_written=settings.method == AS_WRITTEN)
        self._choice = chosen(printer, settings) if settings.method != AS_WRITTEN else Choice(AS_WRITTEN, "")
        self._commander: Commander | None = None
        if self._choice.method != AS_WRITTEN:
            designs = Designs(printer, self._choice.method, settings)
            self._commander, self._filament = Commander(designs, settings.dt), Filament(designs, settings)
        self._drive = Drive(printer, self.motors, settings.dt)
        self._events = 0

    def pieces(
        self, chunks: Iterable[bytes], progress: Callable[[int], None] = lambda done: None
    ) -> Iterator[tuple[Piece, Sequence[Event]]]:
        """The stream, and the events of about the same time. Raises GcodeError (without the file's name), LimitError.

        chunks   : the file's text, whole lines
        progress : told how many bytes of it have been read
        """
        for portion in self._reader.portions(chunks, progress):
            batch = None
            if self._commander:
                batch = self._filament.pushed(self._commander.batch(portion.part, portion.inside))
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
            method=self._choice.method,
            why=self._choice.why,
            time=round(self._timeline.time, 6),
            lines=self._reader.count,
            moves=self._reader.moves,
            motors=self._drive.told(),
            events=self._events,
            warnings=self._warnings(),
        )

    def _warnings(self) -> tuple[str, ...]:
        told = list(self._reader.warnings)
        if self._commander and (remedy := self._commander.remedies.told):
            told.append(remedy)
        if self._printer.e_steps_per_mm is None:
            told.append(NO_E)
        if sets := self._timeline.sets:
            told.append(f"the machine was set to another position {len(sets)} times, first before line {sets[0]}")
        return tuple(told)
