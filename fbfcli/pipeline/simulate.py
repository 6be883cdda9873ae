"""The order of the steps: text, motion, plants, errors; method after method."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from fbfcli.control.shapers import MAX_DAMPING, impulses
from fbfcli.errors import ModelError
from fbfcli.pipeline.compensate import check_ceilings, compensate
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.drawing import Drawing
from fbfcli.pipeline.machine import Condition, conditions, family
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.settings import AS_WRITTEN, AUTO, Settings
from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.timeline import Timeline
from fbfcli.pipeline.watcher import Watcher
from fbfcli.printer import Printer
from fbfcli.verify.firmware import planner_of
from fbfcli.verify.input_shaping import InputShaping
from fbfcli.verify.shaper_tuning import MadeFor, best, klippers

FIRMWARE = "firmware "  # before the name of a shaper that the firmware itself applies
RATE_HZ = 1000.0


@dataclass(frozen=True)
class Wanted:
    """What is to be simulated.

    methods       : names of control.design.METHODS, AUTO, or FIRMWARE and one of Klipper's shapers
    accelerations : to plan with, each in turn [mm/s^2]; None: the settings'
    mismatches    : the machine's frequencies are off by these parts too, and its dampings; none: it is as modelled
    family        : and it is each of the machines that its profile's uncertainty describes
    rate          : samples a second, a multiple of the trajectory's
    machine       : that draws the print; None: the printer that the text is meant for
    stamped       : the file is compensated already: the methods are but a name for executing it as it is written
    """

    methods: tuple[str, ...] = (AS_WRITTEN, AUTO)
    accelerations: tuple[float | None, ...] = (None,)
    mismatches: tuple[float, ...] = ()
    family: bool = False
    rate: float = RATE_HZ
    machine: Printer | None = None
    stamped: bool = False

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
    watchers: Sequence[Watcher] = (),
) -> Simulation:
    """Execute a file by every method, and drive the machine with it.

    open_text : gives the file's text, whole lines, as often as it is asked
    progress  : told how many bytes have been read, of all passes
    watchers  : see the passes with the first of the accelerations

    A method that cannot work on the printer's model is left out, unless it is the only one.
    Raises GcodeError (without the file's name), LimitError, ModelError, ProfileError.
    """
    machine = wanted.machine or printer
    under = conditions(wanted.mismatches) + (family(machine) if wanted.family else ())
    results, refused, reading = [], dict[str, str](), _Reading(open_text, progress)
    for acceleration in wanted.accelerations:
        how = settings if acceleration is None else replace(settings, acceleration=acceleration)
        check_ceilings(printer, how)
        first: Drawing | None = None
        for method in wanted.methods:
            seeing = watchers if acceleration == wanted.accelerations[0] else ()
            one: _Pass | None = None
            try:
                one = _Pass(method, printer, how, wanted, under, seeing, first)
                results.append(one.run(reading))
            except ModelError as why:
                if len(wanted.methods) == 1 or (one and one.drawing.begun):
                    raise
                refused[method] = str(why)
                continue
            first = first or one.drawing
    if first is None:
        raise ModelError("; ".join(f"{method}: {why}" for method, why in refused.items()))
    marks = first.marks
    left_out = tuple(f"{method} is left out: {why}" for method, why in refused.items())
    return Simulation(
        printer.name, machine.name, wanted.rate, tuple(marks.features), marks.layers, under, tuple(results), left_out
    )


class _Reading:
    """A file read again and again: how many bytes in all."""

    def __init__(self, open_text: Callable[[], Iterable[bytes]], progress: Callable[[int], None]):
        self._open, self._progress = open_text, progress
        self._read = 0

    def __iter__(self) -> Iterator[bytes]:
        for text in self._open():
            yield text
            self._read += len(text)
            self._progress(self._read)


class _Pass:
    """One pass over the file: one method, at one acceleration. Raises ModelError, before anything is drawn where the
    method is not for the model.
    """

    def __init__(
        self,
        name: str,
        printer: Printer,
        settings: Settings,
        wanted: Wanted,
        under: Sequence[Condition],
        watchers: Sequence[Watcher],
        first: Drawing | None,
    ):
        self._name, self._printer, self._settings, self._wanted = name, printer, settings, wanted
        self._dt = 1.0 / wanted.rate
        shaper = name.removeprefix(FIRMWARE)
        self._in_firmware = shaper != name
        self._made_for: tuple[MadeFor, ...] = ()
        if shaper in MAX_DAMPING:
            self._made_for = _made_for(printer, shaper, settings, klippers if self._in_firmware else best)
        shaping = None
        if self._in_firmware:
            made = [impulses(shaper, one.frequency, one.damping) for one in self._made_for]
            shaping = InputShaping(made, self._dt)
        self.drawing = Drawing(name, wanted.machine or printer, under, self._dt, watchers, shaping, first)
        self.marks = self.drawing.marks

    @property
    def _is_as_written(self) -> bool:
        """The file is executed as it is."""
        return self._wanted.stamped or self._in_firmware or self._name == AS_WRITTEN

    @property
    def _how(self) -> Settings:
        """Of the compensation."""
        x, y = (one.frequency for one in self._made_for) if self._made_for else (None, None)
        shaped = self._settings.shaped if x is None or y is None else (x, y)
        return replace(self._settings, method=self._name, shaped=shaped)

    def run(self, text: Iterable[bytes]) -> Simulated:
        """Everything of it."""
        chunks = self.marks.passing(text)
        if self._is_as_written:
            return self._as_written(chunks)
        return self._compensated(chunks)

    def _as_written(self, chunks: Iterable[bytes]) -> Simulated:
        """The firmware executes the file as it is."""
        settings = replace(self._settings, method=AS_WRITTEN)
        planner = planner_of(
            self._printer, settings.segments_per_second, segment_s=0.0 if self._wanted.stamped else None
        )
        reader, timeline = Reader(self._printer, settings, as_written=True, planner=planner), Timeline(self._dt)
        for portion in reader.portions(chunks, lambda read: None):
            track, _ = timeline.part(portion.part, portion.inside, None, portion.lines)
            self.drawing.track(track)
        return self._told(AS_WRITTEN, "", timeline.time, tuple(reader.warnings))

    def _compensated(self, chunks: Iterable[bytes]) -> Simulated:
        """The firmware executes what a method makes of the file."""
        draw = self.drawing.stretches
        told = compensate(chunks, self._printer, self._how, lambda text: None, lambda read: None, draw).summary
        return replace(self._told(told.method, told.why, told.time, told.warnings), compensated=told)

    def _told(self, method: str, why: str, time: float, warnings: tuple[str, ...]) -> Simulated:
        figures, motors = self.drawing.finish()
        return Simulated(
            name=self._name,
            method=method,
            why=why,
            made_for=self._made_for,
            acceleration=self._settings.acceleration,
            time=time,
            figures=figures,
            motors=motors,
            compensated=None,
            warnings=warnings,
        )


def _made_for(
    printer: Printer, shaper: str, settings: Settings, choose: Callable[..., MadeFor | None]
) -> tuple[MadeFor, ...]:
    """What a shaper is made for on X and Y. Raises ModelError where it cannot be."""
    plants = Designs(printer, AS_WRITTEN, Settings(dt=settings.dt)).plants(0)
    found = [choose(shaper, plant) for plant in plants]
    made = tuple(one for one in found if one is not None)
    if len(made) < len(found):
        raise ModelError(f"a shaper ({shaper}) needs an oscillating mode and a model has none; leave it out")
    return made
