"""The order of the steps: text, motion, plants, errors; method after method."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from fbfcli.gcode.marks import Marks
from fbfcli.pipeline.compensate import check_ceilings, compensate
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.executions import Executions
from fbfcli.pipeline.machine import Condition, conditions, plants_of
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.settings import AUTO, Settings
from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.timeline import Timeline
from fbfcli.printer import Printer
from fbfcli.verify.account import Account, Accounted
from fbfcli.verify.execution import Execution
from fbfcli.verify.passage import Passage
from fbfcli.verify.passages import Passages

AS_WRITTEN = "none"  # the method that changes nothing: the firmware's own plan
RATE_HZ = 1000.0


@dataclass(frozen=True)
class Wanted:
    """What is to be simulated.

    methods       : names of control.design.METHODS, or AUTO
    accelerations : to plan with, each in turn [mm/s^2]; None: the settings'
    mismatch      : the machine's frequencies are off by this part too, and its dampings; None: it is as modelled
    rate          : samples a second, a multiple of the trajectory's
    machine       : that draws the print; None: the printer that the text is meant for
    """

    methods: tuple[str, ...] = (AS_WRITTEN, AUTO)
    accelerations: tuple[float | None, ...] = (None,)
    mismatch: float | None = None
    rate: float = RATE_HZ
    machine: Printer | None = None

    @property
    def passes(self) -> int:
        """How many times the file is read."""
        return len(self.methods) * len(self.accelerations)


def simulate(
    open_text: Callable[[], Iterable[bytes]],
    printer: Printer,
    settings: Settings,
    wanted: Wanted,
    progress: Callable[[int], None] = lambda done: None,
    watch: Callable[[str, Passage], None] = lambda name, passage: None,
) -> Simulation:
    """Execute a file by every method, and drive the machine with it.

    open_text : gives the file's text, whole lines, as often as it is asked
    progress  : told how many bytes have been read, of all passes
    watch     : told what the machine draws as modelled, method after method

    Raises GcodeError (without the file's name), LimitError, ModelError, ProfileError.
    """
    machine = wanted.machine or printer
    under = conditions(wanted.mismatch)
    results, read = [], 0
    for acceleration in wanted.accelerations:
        how = settings if acceleration is None else replace(settings, acceleration=acceleration)
        check_ceilings(printer, how)
        for method in wanted.methods:
            drawn = _Drawn(machine, under, wanted.rate, lambda passage, name=method: watch(name, passage))  # type: ignore[misc]
            before = read

            def passed(done: int, before: int = before) -> None:
                nonlocal read
                read = before + done
                progress(read)

            one = _as_written if method == AS_WRITTEN else _compensated
            results.append(one(open_text(), printer, replace(how, method=method), drawn, passed))
    return Simulation(printer.name, machine.name, wanted.rate, under, tuple(results), ())


class _Drawn:
    """One print as the machine draws it, under every condition."""

    def __init__(
        self, machine: Printer, under: tuple[Condition, ...], rate: float, watch: Callable[[Passage], None]
    ):
        self.dt = 1.0 / rate
        designs = Designs(machine, AS_WRITTEN, Settings(dt=self.dt))
        self.marks = Marks()
        self.executions = Executions(self.marks, designs, self.dt)
        self._passages = [Passages(plants_of(designs, condition, self.dt)) for condition in under]
        self._accounts = [Account() for _ in under]
        self._watch = watch

    def add(self, execution: Execution) -> None:
        """Draw more of it."""
        for i, passages in enumerate(self._passages):
            self._count(i, passages.add(execution))

    def figures(self) -> tuple[Accounted, ...]:
        """Of each condition; no more will come."""
        for i, passages in enumerate(self._passages):
            self._count(i, passages.finish())
        return tuple(account.figures() for account in self._accounts)

    def _count(self, i: int, passage: Passage | None) -> None:
        if passage is not None:
            self._accounts[i].add(passage)
            if i == 0:
                self._watch(passage)


def _as_written(
    chunks: Iterable[bytes], printer: Printer, settings: Settings, drawn: _Drawn, progress: Callable[[int], None]
) -> Simulated:
    """The firmware executes the file as it is."""
    reader, timeline = Reader(printer, settings, as_written=True), Timeline(drawn.dt)
    for portion in reader.portions(drawn.marks.passing(chunks), progress):
        track, _ = timeline.part(portion.part, portion.inside, None, portion.lines)
        if len(track):
            drawn.add(drawn.executions.of_track(track))
    figures = drawn.figures()
    return Simulated(
        AS_WRITTEN, AS_WRITTEN, "", settings.acceleration, timeline.time, figures, None, tuple(reader.warnings)
    )


def _compensated(
    chunks: Iterable[bytes], printer: Printer, settings: Settings, drawn: _Drawn, progress: Callable[[int], None]
) -> Simulated:
    """The firmware executes what a method makes of the file."""
    done = compensate(
        drawn.marks.passing(chunks),
        printer,
        settings,
        lambda text: None,
        progress,
        lambda part: drawn.add(drawn.executions.of_stretches(part)),
    )
    told = done.summary
    figures = drawn.figures()
    return Simulated(
        settings.method, told.method, told.why, settings.acceleration, told.time, figures, told, told.warnings
    )
