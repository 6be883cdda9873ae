"""Between the places that models were measured at: shares of each, and the model they make together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from fbfcli.plant.model import impulse_response, mean_response, plant_of
from fbfcli.printer import ImpulseResponse, ModalModel, Mode, Model, Place


def shares(places: Sequence[Place], at: np.ndarray) -> np.ndarray:
    """What part each place has in the model at other places, shape (n, k), rows sum to 1.

    places : k of them, all told by the same coordinates
    at     : ndarray, shape (n, 4)   X Y Z [mm] and printed mass [kg]

    Along one coordinate linear between neighbours, constant beyond the ends. In several, each in units of its range,
    by the inverse square of the distance (Shepard 1968).
    """
    told = np.array([[np.nan if v is None else v for v in astuple(place)[1:]] for place in places], dtype=float)
    varies = np.flatnonzero(np.ptp(told, axis=0) > 0.0)  # nan where it is not told
    if not len(varies):
        return np.tile(np.eye(1, len(places)), (len(at), 1))
    if len(varies) == 1:
        return _linear(told[:, varies[0]], at[:, varies[0]])
    known, here = (each[:, varies] / np.ptp(told[:, varies], axis=0) for each in (told, at))
    square = np.square(here[:, None] - known).sum(axis=2)
    near = np.min(square, axis=1, keepdims=True)
    weight = np.where(near > 0.0, near / np.where(square > 0.0, square, 1.0), square == 0.0)
    return weight / weight.sum(axis=1, keepdims=True)


def between(models: Sequence[Model], share: Sequence[float], dt: float, axis: str) -> Model:
    """The model that has `share` of each.

    Modes, as many in each model and in rising order: 1 / f^2 is linear in a mass that is added and in a length that
    bends, so it is what is interpolated; damping and gain are taken linearly. Anything else: the mean of the impulse
    responses of period dt [s]; `axis` names it in errors. Raises ModelError.
    """
    part = [(model, s) for model, s in zip(models, share, strict=True) if s > 0.0]
    if len(part) == 1:
        return part[0][0]
    modal = [(_rising(model), s) for model, s in part if isinstance(model, ModalModel)]
    if len(modal) == len(part) and len({len(modes) for modes, _ in modal}) == 1:
        rows = [np.array([(m.frequency**-2, m.damping, m.gain) for m in modes]) * s for modes, s in modal]
        return ModalModel(tuple(Mode(f**-0.5, zeta, gain) for f, zeta, gain in np.sum(rows, axis=0).tolist()))
    responses = [impulse_response(plant_of(model, dt, axis)) for model, _ in part]
    return ImpulseResponse(tuple(mean_response(responses, [s for _, s in part]).tolist()), dt)


def _linear(known: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Hat functions over the known coordinates, shape (n, k)."""
    order = np.argsort(known)
    hats = np.empty((len(at), len(known)))
    for i, place in enumerate(order.tolist()):
        hats[:, place] = np.interp(at, known[order], np.eye(len(known))[i])
    return hats


def _rising(model: ModalModel) -> tuple[Mode, ...]:
    return tuple(sorted(model.modes, key=lambda mode: mode.frequency))
