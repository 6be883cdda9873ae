"""How far an axis swings when its acceleration changes: what acceleration keeps it within a given error.

e(t) : position less command, after a step of acceleration of 1 mm/s^2 [s^2]; h impulse response of the plant
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fbfcli.plant.model import Plant, impulse_response


def following_error(plant: Plant) -> np.ndarray:
    """e at multiples of dt [s^2]: (H - 1) / s^3, the ramp's own lag (a delay along the path) left out."""
    return _after_a_step(np.append(impulse_response(plant), 0.0), plant.dt)


def difference(one: Plant, other: Plant) -> np.ndarray:
    """What a command made for one plant leaves on another: e of the difference of their responses."""
    h, g = impulse_response(one), impulse_response(other)
    n = max(len(h), len(g))
    apart = np.pad(h, (0, n - len(h))) - np.pad(g, (0, n - len(g)))
    return _integrated(apart, one.dt)


def most_acceleration(errors: Sequence[np.ndarray], error: float) -> float:
    """The acceleration [mm/s^2] at which the worst of these swings reaches `error` [mm]."""
    peak = max((float(np.abs(e).max()) for e in errors), default=0.0)
    return error / peak if peak > 0 else float("inf")


def _after_a_step(h: np.ndarray, dt: float) -> np.ndarray:
    apart = h.copy()
    apart[0] -= 1.0
    return _integrated(apart, dt)


def _integrated(apart: np.ndarray, dt: float) -> np.ndarray:
    """Three sums of a difference of impulse responses; a mere delay between them, growing with speed, is taken out."""
    position = np.cumsum(apart)
    lag = position.sum()  # what a constant velocity is behind, in samples
    return np.asarray(np.cumsum(np.cumsum(position) - lag) * dt**2)
