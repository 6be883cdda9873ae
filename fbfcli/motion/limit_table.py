"""Every set of limits that a file's moves are planned under, each once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fbfcli.printer import Limits


class LimitTable:
    """Indices of limits, growing as a file is read."""

    def __init__(self) -> None:
        self._index: dict[Limits, int] = {}

    @property
    def limits(self) -> tuple[Limits, ...]:
        """All of them, in the order of their indices."""
        return tuple(self._index)

    def index(self, limits: tuple[Limits, ...]) -> np.ndarray:
        """Index of each of the given limits, int, shape (k,)."""
        return np.array([self._index.setdefault(one, len(self._index)) for one in limits], dtype=np.int64)


def overridden(limits: Limits, acceleration: float | None, velocity: float | None) -> Limits:
    """The limits with --accel and --velocity in their place, in X and Y."""
    if acceleration is not None:
        x, y, z, e = limits.axis_acceleration
        limits = replace(limits, acceleration=acceleration, travel_acceleration=acceleration,
                         axis_acceleration=(max(x, acceleration), max(y, acceleration), z, e))
    if velocity is not None:
        _, _, z, e = limits.axis_velocity
        limits = replace(limits, velocity=velocity, axis_velocity=(velocity, velocity, z, e))
    return limits
