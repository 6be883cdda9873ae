"""What follows from a model, whatever it was found from: its discrete form, accelerations, Klipper's choice."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from fbfcli.control.shapers import impulses
from fbfcli.errors import ModelError
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.identified import Identified
from fbfcli.plant import acceleration_error
from fbfcli.plant.intervals import ModeEstimate
from fbfcli.plant.model import Plant, plant_of
from fbfcli.plant.rational import Rational, profile_model
from fbfcli.plant.shaper_score import DAMPING, Scored, best_shaper, most_acceleration
from fbfcli.plant.spread import noise_spread
from fbfcli.printer import Model


def concluded(
    axis: str, names: Sequence[str], assumed: str, rational: Rational, modes: tuple[ModeEstimate, ...], ask: Ask,
    possible: Sequence[Model] | None, psd: tuple[np.ndarray, np.ndarray] | None,
) -> Identified:  # fmt: skip
    """What follows from a model, whatever it was found from."""
    model = profile_model(rational, ask.dt)
    plant = plant_of(model, ask.dt, axis.upper())
    others = _plants(possible or (), ask.dt, axis.upper())
    swings = [acceleration_error.following_error(one) for one in (plant, *others)]
    left = [acceleration_error.difference(plant, other) for other in others]
    shaper, kinds, most = klipper_choice(psd)
    return Identified(
        axis=axis,
        source=tuple(names),
        assumed=assumed,
        model=model,
        rational=rational,
        modes=modes,
        spread=noise_spread(modes),
        notes=(),
        hints=(),
        shaper=shaper,
        shapers=kinds,
        shaper_acceleration=most,
        error=ask.error,
        by_model=acceleration_error.most_acceleration(swings[:1], ask.error),
        uncompensated=acceleration_error.most_acceleration(swings, ask.error),
        compensated=acceleration_error.most_acceleration(left, ask.error) if left else None,
    )


def _plants(models: Sequence[Model], dt: float, axis: str) -> list[Plant]:
    """Plants of those models that make one: a draw may have no damping left."""
    plants = []
    for model in models:
        with suppress(ModelError):
            plants.append(plant_of(model, dt, axis))
    return plants


def klipper_choice(psd: tuple[np.ndarray, np.ndarray] | None) -> tuple[Scored | None, tuple[Scored, ...], float]:
    """Klipper's choice, those of each kind, and the acceleration that it suggests."""
    if psd is None:
        return None, (), float("nan")
    best, kinds = best_shaper(*psd, impulses)
    return best, kinds, most_acceleration(*impulses(best.name, best.frequency, DAMPING))
