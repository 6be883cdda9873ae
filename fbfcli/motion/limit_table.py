"""Every set of limits that a file's moves are planned under, each once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fbfcli.printer import Limits

E_VELOCITY_SHARE = 0.9
E_ACCELERATION_SHARE = 0.5


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


def compensated(limits: Limits, acceleration: float | None, velocity: float | None) -> Limits:
    """The limits that compensated moves are planned with: --accel and --velocity in the place of X's and Y's.

    Where E's own limits bind (a wipe at retraction speed), segments must keep within them too, and a chord is faster
    than the curve it stands for: E is planned with a margin.
    """
    x, y, z, e = limits.axis_acceleration
    axis_acceleration = (x, y, z, E_ACCELERATION_SHARE * e)
    axis_velocity = (*limits.axis_velocity[:3], E_VELOCITY_SHARE * limits.axis_velocity[3])
    if acceleration is not None:
        limits = replace(limits, acceleration=acceleration, travel_acceleration=acceleration)
        axis_acceleration = (max(x, acceleration), max(y, acceleration), *axis_acceleration[2:])
    if velocity is not None:
        limits = replace(limits, velocity=velocity)
        axis_velocity = (velocity, velocity, *axis_velocity[2:])
    return replace(limits, axis_acceleration=axis_acceleration, axis_velocity=axis_velocity)
