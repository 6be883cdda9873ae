"""Options that several verbs share."""

from __future__ import annotations

from math import isfinite
from typing import Any

import click


class Number(click.FloatRange):
    """A finite number in a range: click's own lets nan and inf through."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


class Numbers(click.ParamType):
    """Positive numbers up to `most`, with commas between them; a % after one is taken as said."""

    name = "numbers"

    def __init__(self, most: float | None = None):
        self._one = Number(min=0, min_open=True, max=most)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        words = [word.strip().removesuffix("%") for word in str(value).split(",")]
        return tuple(dict.fromkeys(self._one.convert(word, param, ctx) for word in words))


printer_option = click.option(
    "-p", "--printer", metavar="NAME|FILE", help="Printer profile (else FBF_PRINTER, else ~/.config/fbf/printer.toml)."
)
json_option = click.option("--json", "json_to", metavar="FILE", help="Write the summary as JSON; - is standard output.")
quiet_option = click.option("-q", "--quiet", is_flag=True, help="No progress, no summary; errors are still told.")

# how a file is planned, compensated and written
spread_option = click.option(
    "--spread",
    type=Number(0, 50),
    metavar="PERCENT",
    help="How far frequencies may be from the models' (auto, robust, robust_fbf, contour). "
    "[default: the profile's, else 15]",
)
velocity_option = click.option(
    "--velocity", type=Number(min=1), metavar="MM/S", help="Plan with this speed limit instead of the file's."
)
tolerance_option = click.option(
    "--tolerance",
    type=Number(0.1, 1000),
    default=5.0,
    show_default=True,
    metavar="UM",
    help="Of a written segment from the command.",
)
segments_option = click.option(
    "--segments",
    type=Number(min=10),
    metavar="PER_S",
    help="Segments per second the firmware takes. [default: the profile's]",
)
