"""How uncertain a model is, told from data: one recording's noise, or runs, amplitudes and positions apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fbfcli.plant.candidate import Candidate
from fbfcli.plant.fit import best_of_shape
from fbfcli.plant.frf import Frf
from fbfcli.plant.intervals import ModeEstimate, mode_estimates
from fbfcli.plant.model import modes as vibrations
from fbfcli.plant.model import plant_of
from fbfcli.plant.rational import profile_model
from fbfcli.plant.shape import model_of
from fbfcli.printer import WIDEST, Family, Model, Spread

PERIOD = 1e-3  # s, at which modes of models are compared
LEAST = 0.005  # of a frequency: machines change by more between two prints (temperature, belts, the part's mass)


def noise_spread(modes: Sequence[ModeEstimate]) -> Spread:
    """Ranges from the confidence of one recording's strongest mode."""
    strongest = modes[0]
    half = max(LEAST, strongest.frequency.high / strongest.frequency.value - 1)
    low, high = strongest.damping.low / strongest.damping.value, strongest.damping.high / strongest.damping.value
    return _bounded((1 - half, 1 + half), (low, high))


def group_fits(groups: Sequence[Frf], chosen: Candidate) -> tuple[Candidate, ...]:
    """The chosen shape fitted to each group of recordings by itself; groups that do not support it are left out."""
    fits = (best_of_shape(group, chosen.shape, float(chosen.theta[1])) for group in groups)
    return tuple(fit for fit in fits if fit is not None)


def strongest_frequencies(fits: Sequence[Candidate]) -> list[float]:
    """Of each fit's strongest mode [Hz]."""
    certain = (np.zeros((fit.shape.size, fit.shape.size)) for fit in fits)
    return [mode_estimates(fit, cov)[0].frequency.value for fit, cov in zip(fits, certain, strict=True)]


def group_spread(fits: Sequence[Candidate], dt: float) -> Family:
    """One model for each group, all as probable."""
    models = tuple(profile_model(model_of(fit.shape, fit.theta), dt) for fit in fits)
    return Family(models, tuple(float(w) for w in np.full(len(models), 1 / len(models))))


def as_ranges(spread: Spread | Family, model: Model) -> Spread:
    """Ranges that hold the strongest modes of a family about its model's."""
    if isinstance(spread, Spread):
        return spread
    own, *others = (vibrations(plant_of(one, PERIOD, ""))[0] for one in (model, *spread.models))
    q = [one.frequency / own.frequency for one in others]
    d = [one.damping / own.damping for one in others]
    return _bounded((min(1 - LEAST, *q), max(1 + LEAST, *q)), (min(1.0, *d), max(1.0, *d)))


def _bounded(frequency: tuple[float, float], damping: tuple[float, float]) -> Spread:
    """Ranges as a profile may hold them."""
    (f, g), (c, d) = ((max(low, 1 / WIDEST), min(high, WIDEST)) for low, high in (frequency, damping))
    return Spread((f, g), (c, d))
