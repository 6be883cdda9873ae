"""`--at x=100,y=20`: where in the machine, or with how much printed, a recording was made."""

from __future__ import annotations

from math import isfinite
from typing import Any

import click

from fbfcli.printer import COORDINATES


class At(click.ParamType):
    """Coordinates by name: position [mm] and printed mass [kg]."""

    name = "place"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, float]:
        if isinstance(value, dict):
            return value
        place: dict[str, float] = {}
        for part in value.split(","):
            name, _, number = (word.strip() for word in part.partition("="))
            if name not in COORDINATES or name in place:
                self.fail(f"{part.strip()!r}: any of {', '.join(COORDINATES)}, once each, as x=100,y=20", param, ctx)
            place[name] = self._number(name, number, param, ctx)
        return {name: place[name] for name in COORDINATES if name in place}

    def _number(self, name: str, text: str, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = float(text)
        except ValueError:
            number = float("nan")
        if not isfinite(number) or (name == "mass" and number < 0.0):
            self.fail(f"{name}={text}: must be a number{' of kg, not negative' * (name == 'mass')}", param, ctx)
        return number
