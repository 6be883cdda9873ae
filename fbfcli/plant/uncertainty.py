"""The family of plants that an axis may really be: its model with frequencies and dampings drawn from ranges, or named
models.

q factor on frequencies      d factor on dampings      lambda_j probability of member j, sum 1
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

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

    What oscillates is changed: modes, and a transfer function's oscillating poles and zeros; its real ones, a drive's
    filter or a sensor's, have no part in a belt's stiffness or a bed's mass. Of a response, where these cannot be told
    apart, time is resampled. Raises ModelError.
    """
    if isinstance(model, ModalModel):
        modes = (Mode(q * m.frequency, min(d * m.damping, MOST_DAMPING), m.gain) for m in model.modes)
        return plant_of(ModalModel(tuple(modes)), dt, axis)
    if isinstance(model, TransferFunction):
        return tuned(plant_of(model, dt, axis), q, d)
    if q != 1.0 and isinstance(model, FrequencyResponse):
        model = replace(model, frequency=tuple(q * f for f in model.frequency))
    elif q != 1.0 and isinstance(model, ImpulseResponse):
        model = replace(model, dt=model.dt / q)
    return tuned(plant_of(model, dt, axis), 1.0, d)


def tuned(plant: Plant, q: float, d: float) -> Plant:
    """Oscillating poles and zeros at q times their frequency, the poles' damping ratios d times what they are.

    What does not oscillate stays, and so does the DC gain; of a plant without poles, nothing changes.
    """
    if (q, d) == (1.0, 1.0) or len(plant.a) == 1:
        return plant
    a = np.real(np.poly(_turned(np.roots(plant.a), q, d)))
    b = plant.b
    if q != 1.0:
        first = int(np.flatnonzero(b)[0])  # samples of delay
        b = np.concatenate([np.zeros(first), np.atleast_1d(np.real(np.poly(_turned(np.roots(b), q, 1.0))))])
    return Plant(b * (a.sum() / b.sum()), a, plant.dt)


def _turned(roots: np.ndarray, q: float, d: float) -> np.ndarray:
    """Oscillating roots in z at q times their frequency and d times their damping ratio, the others as they are."""
    z = roots.astype(complex)
    swings = np.abs(z.imag) > 1e-9
    swings &= q * np.abs(np.angle(z)) < np.pi  # the others would come out at another frequency
    s = np.log(z[swings])
    w = np.abs(s)
    own = -s.real / w  # negative of a zero outside the unit circle
    zeta = np.minimum(d * own, np.maximum(own, MOST_DAMPING))
    z[swings] = np.exp(q * w * (-zeta + 1j * np.sign(s.imag) * np.sqrt(1 - zeta**2)))
    return z
