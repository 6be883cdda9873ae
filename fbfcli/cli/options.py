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
