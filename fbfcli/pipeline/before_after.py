"""A print as sliced and as compensated, drawn side by side while it is compensated: one pass over the file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from fbfcli.pipeline.compensate import Done
from fbfcli.pipeline.drawing import Drawing
from fbfcli.pipeline.machine import conditions
from fbfcli.pipeline.settings import AS_WRITTEN, Settings
from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.watcher import Watcher
from fbfcli.printer import Printer
from fbfcli.verify.tally import Stretches

WRITTEN = "as written"


class BeforeAfter:
    """What the printer's own model draws, as modelled. As sliced, stretches are executed as they are desired."""

    def __init__(self, printer: Printer, settings: Settings, watchers: Sequence[Watcher]):
        self._printer, self._settings, self._under = printer, settings, conditions(())
        name = WRITTEN if settings.method == AS_WRITTEN else settings.method
        self._names = AS_WRITTEN, name
        self._sliced = Drawing(AS_WRITTEN, printer, self._under, settings.dt, watchers)
        self._compensated = Drawing(name, printer, self._under, settings.dt, watchers, like=self._sliced)

    def passing(self, chunks: Iterable[bytes]) -> Iterator[bytes]:
        """The file's text, on its way to be compensated."""
        return self._sliced.marks.passing(self._compensated.marks.passing(chunks))

    def watch(self, part: Stretches) -> None:
        """Draw stretches that have been written."""
        self._sliced.sliced(part)
        self._compensated.stretches(part)

    def simulation(self, done: Done) -> Simulation:
        """The figures of both, once the file is compensated."""
        told, marks = done.summary, self._sliced.marks
        methods, times = (AS_WRITTEN, told.method), (told.time_as_sliced, told.time)
        results = []
        for name, method, time, drawing in zip(
            self._names, methods, times, (self._sliced, self._compensated), strict=True
        ):
            figures, motors = drawing.finish()
            why, compensated = ("", None) if drawing is self._sliced else (told.why, told)
            warnings = () if compensated is None else told.warnings
            acceleration = self._settings.acceleration
            results.append(Simulated(name, method, why, (), acceleration, time, figures, motors, compensated, warnings))
        rate, name = 1.0 / self._settings.dt, self._printer.name
        return Simulation(name, name, rate, tuple(marks.features), marks.layers, self._under, tuple(results))
