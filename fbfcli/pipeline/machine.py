"""The machine that draws a print: what its profile says, and what it may be instead."""

from __future__ import annotations

from collections.abc import Callable
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


def conditions(mismatch: float | None) -> tuple[Condition, ...]:
    """The machine as modelled; with a `mismatch` (a part of 1) its frequencies and dampings off in both directions."""
    if mismatch is None:
        return (NOMINAL,)
    return (
        NOMINAL,
        Condition(f"frequency -{100 * mismatch:g} %", frequency=1.0 - mismatch),
        Condition(f"frequency +{100 * mismatch:g} %", frequency=1.0 + mismatch),
        Condition("damping x 1/2", damping=LESS_DAMPED),
        Condition("damping x 2", damping=MORE_DAMPED),
    )


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
