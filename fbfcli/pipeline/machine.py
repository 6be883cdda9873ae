"""The machine that draws a print: what its profile says, and what it may be instead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from fbfcli.pipeline.designs import BA, Designs
from fbfcli.plant.uncertainty import changed

LESS_DAMPED, MORE_DAMPED = 0.5, 2.0


@dataclass(frozen=True)
class Condition:
    """How a machine differs from its model: factors on its frequencies and dampings, and words for people."""

    name: str
    frequency: float = 1.0
    damping: float = 1.0


NOMINAL = Condition("as modelled")


def conditions(mismatches: Sequence[float]) -> tuple[Condition, ...]:
    """The machine as modelled; with `mismatches` (parts of 1) its frequencies and dampings off in both directions."""
    if not mismatches:
        return (NOMINAL,)
    off = [
        Condition(f"frequency {100 * part:+g} %", frequency=1.0 + part)
        for mismatch in mismatches
        for part in (-mismatch, mismatch)
    ]
    dampings = Condition("damping x 1/2", damping=LESS_DAMPED), Condition("damping x 2", damping=MORE_DAMPED)
    return (NOMINAL, *off, *dampings)


def plants_of(machine: Designs, condition: Condition, dt: float) -> Callable[[int], tuple[BA, BA]]:
    """Coefficients of X and Y at each place of a machine under a condition. Raises ModelError."""

    @cache
    def at(place: int) -> tuple[BA, BA]:
        x, y = (
            changed(model, condition.frequency, condition.damping, dt, name)
            for model, name in zip(machine.models(place), "xy", strict=True)
        )
        return (x.b, x.a), (y.b, y.a)

    return at
