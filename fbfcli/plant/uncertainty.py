"""The family of plants that an axis may really be: its model with frequencies and dampings drawn from ranges, or named
models.

q factor on frequencies      d factor on dampings      lambda_j probability of member j, sum 1
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import ModelError
from fbfcli.plant.model import Plant, impulse_response, mean_response, plant_of
from fbfcli.printer import (
    Family,
    FrequencyResponse,
    ImpulseResponse,
    ModalModel,
    Mode,
    Model,
    Spread,
    TransferFunction,
)

ASSUMED = Spread(frequency=(0.85, 1.15))  # of a profile that does not say: temperature, belts, position and the part
ASSUMED_AT = Spread(frequency=(0.9, 1.1))  # where the profile has models at several places: position and part are known
WIDE, FEW, MANY = 0.11, 5, 7  # members of a family of frequencies, by half its width: their errors must overlap
DAMPINGS = 3  # and of dampings, where those are uncertain too: they matter little
MOST_DAMPING = 0.95


@dataclass(frozen=True)
class Members:
    """Plants G_j and their probabilities.

    plants  : tuple of Plant           all of one period
    weights : ndarray, shape (J,)      lambda_j, sum 1
    """

    plants: tuple[Plant, ...]
    weights: np.ndarray

    def mean(self) -> np.ndarray:
        """Impulse response of the mean plant sum_j lambda_j G_j, sum 1, shape (n,)."""
        return mean_response([impulse_response(plant) for plant in self.plants], self.weights)


def members(model: Model, uncertainty: Spread | Family, dt: float, axis: str) -> Members:
    """The family of an axis whose nominal model is `model`; `axis` names it in errors.

    Any frequency of the range is as likely as any other, and where damping is uncertain its logarithm likewise. Members
    lie at equal distances, and an end stands for half as much of the range as one within it. Raises ModelError.
    """
    if isinstance(uncertainty, Family):
        plants = tuple(plant_of(each, dt, axis) for each in uncertainty.models)
        return Members(plants, np.array(uncertainty.weights))
    (q_low, q_high), (d_low, d_high) = uncertainty.frequency, uncertainty.damping
    many = MANY if q_high - q_low > 2 * WIDE else FEW
    q = np.linspace(q_low, q_high, many) if q_high > q_low else np.array([q_low])
    d = np.geomspace(d_low, d_high, DAMPINGS) if d_high > d_low else np.array([d_low])
    plants = tuple(changed(model, q_j, d_j, dt, axis) for q_j in q.tolist() for d_j in d.tolist())
    return Members(plants, np.outer(_shares(len(q)), _shares(len(d))).ravel())


def _shares(n: int) -> np.ndarray:
    """Part of a range that each of n points at equal distances stands for, the ends among them; shape (n,), sum 1."""
    share = np.ones(n)
    if n > 1:
        share[[0, -1]] = 0.5
    return share / share.sum()


def changed(model: Model, q: float, d: float, dt: float, axis: str) -> Plant:
    """The plant of a model whose frequencies are q times, and dampings d times, what it says.

    Modes are changed themselves; of anything else, time is resampled, which keeps its zeros and lag in step with its
    poles. Raises ModelError.
    """
    if isinstance(model, ModalModel):
        modes = (Mode(q * m.frequency, min(d * m.damping, MOST_DAMPING), m.gain) for m in model.modes)
        return plant_of(ModalModel(tuple(modes)), dt, axis)
    if q == 1.0:
        plant = plant_of(model, dt, axis)
    elif isinstance(model, FrequencyResponse):
        plant = plant_of(replace(model, frequency=tuple(q * f for f in model.frequency)), dt, axis)
    else:
        plant = _faster(model, q, dt, axis)
    return damped(plant, d)


def damped(plant: Plant, d: float) -> Plant:
    """The plant with the damping ratio of every oscillating pole d times what it is; zeros and DC gain stay."""
    if d == 1.0 or len(plant.a) == 1:
        return plant
    p = np.roots(plant.a).astype(complex)
    swings = np.abs(p.imag) > 1e-9
    s = np.log(p[swings])
    w = np.abs(s)
    zeta = np.minimum(-d * s.real / w, MOST_DAMPING)
    p[swings] = np.exp(w * (-zeta + 1j * np.sign(s.imag) * np.sqrt(1 - zeta**2)))
    a = np.real(np.poly(p))
    return Plant(plant.b * (a.sum() / plant.b.sum()), a, plant.dt)


def _faster(model: TransferFunction | ImpulseResponse, q: float, dt: float, axis: str) -> Plant:
    """h(t) becomes q h(q t): the same numbers at a period q times shorter."""
    try:
        return plant_of(replace(model, dt=model.dt / q), dt, axis)
    except ModelError:  # a transfer function that cannot be brought to another period still has a response that can
        h = impulse_response(plant_of(model, dt, axis))
        return plant_of(ImpulseResponse(tuple(h.tolist()), dt / q), dt, axis)
