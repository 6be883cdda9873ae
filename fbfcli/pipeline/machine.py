"""The machine that draws a print: what its profile says, and what it may be instead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.settings import AS_WRITTEN, Settings
from fbfcli.plant.model import BA, Plant
from fbfcli.plant.uncertainty import Members, changed
from fbfcli.printer import Printer

LESS_DAMPED, MORE_DAMPED = 0.5, 2.0


@dataclass(frozen=True)
class Condition:
    """How a machine differs from its model, and words for people.

    frequency, damping : factors on those of its modes
    member             : of the families that its axes may really be of, where in them from 0 to 1; None: the model
    """

    name: str
    frequency: float = 1.0
    damping: float = 1.0
    member: float | None = None


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


def family(machine: Printer) -> tuple[Condition, ...]:
    """A condition for each of the machines that the profile's uncertainty describes, or that are assumed."""
    count = max(len(axis.plants) for axis in Designs(machine, AS_WRITTEN, Settings()).families(0))
    if count == 1:
        return ()
    return tuple(Condition(f"family {k + 1}/{count}", member=k / (count - 1)) for k in range(count))


def plants_of(machine: Designs, condition: Condition, dt: float) -> Callable[[int], tuple[BA, BA]]:
    """Coefficients of X and Y at each place of a machine under a condition. Raises ModelError."""

    @cache
    def at(place: int) -> tuple[BA, BA]:
        if condition.member is not None:
            x, y = (_member(axis, condition.member) for axis in machine.families(place))
            return (x.b, x.a), (y.b, y.a)
        x, y = (
            changed(model, condition.frequency, condition.damping, dt, name)
            for model, name in zip(machine.models(place), "xy", strict=True)
        )
        return (x.b, x.a), (y.b, y.a)

    return at


def _member(axis: Members, where: float) -> Plant:
    return axis.plants[round(where * (len(axis.plants) - 1))]
