"""The report of a simulation and the picture of its worst corner: options, and files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fbfcli.cli.files import DASH, saying, writing
from fbfcli.errors import FbfError

if TYPE_CHECKING:
    from fbfcli.pipeline.settings import Settings
    from fbfcli.pipeline.simulation import Simulation
    from fbfcli.printer import Printer
    from fbfcli.verify.traces import Traces


report_option = click.option(
    "--report", metavar="FILE", help="Write a page to look at: layers, corners, curves, tables."
)
png_option = click.option("--png", metavar="FILE", help="Draw the worst corner, before and after.")


class Pictures:
    """What is to be drawn: of a simulation that it watches. `report`, `png`: names of files, or None."""

    def __init__(self, report: str | None, png: str | None = None):
        self._report, self._png = report, png
        self._traces: Traces | None = None
        if report or png:
            from fbfcli.verify.traces import Traces

            self._traces = Traces()

    @property
    def watchers(self) -> tuple[Traces, ...]:
        """Who has to see the simulation."""
        return (self._traces,) if self._traces else ()

    def write(self, file: str, simulation: Simulation, printer: Printer, machine: Printer, settings: Settings) -> None:
        """Draw all of it. Raises FbfError where there is no corner to show."""
        if self._traces is None:
            return
        from fbfcli.pipeline.reported import page, picture

        title, kept = "standard input" if file == DASH else Path(file).name, self._traces.kept()
        if self._report:
            with saying(self._report) as say:
                say(page(title, kept, simulation, printer, machine, settings))
        if self._png:
            drawn = picture(title, kept, simulation)
            if drawn is None:
                raise FbfError(f"{self._png}: nothing moves X or Y in {file}: there is no corner to draw")
            with writing(self._png) as stream:
                stream.write(drawn)
