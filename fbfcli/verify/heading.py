"""Which way a path goes: what an error is along it and across it."""

from __future__ import annotations

import numpy as np

SLOW = 1.0  # mm/s: slower, a direction means nothing


def moving(desired: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement to each sample of a path (n, 2), (n, 2) [mm], and whether it goes faster than SLOW, bool, (n,)."""
    step = np.diff(desired, axis=0, prepend=desired[:1])
    return step, np.hypot(*step.T) > SLOW * dt


class Heading:
    """Directions of a path that is fed piece by piece."""

    def __init__(self, dt: float):
        self._dt = dt
        self._last: np.ndarray | None = None  # sample
        self._unit = np.zeros(2)  # direction of the last motion

    def follow(self, desired: np.ndarray, begin: np.ndarray) -> np.ndarray:
        """Unit vectors along the path at more of its samples (n, 2), shape (n, 2).

        begin : ndarray of int, shape (s,)   samples at which a stretch begins

        Where it stands, the direction is the one in which it came; (0, 0) before it has gone anywhere.
        """
        n = len(desired)
        if not n:
            return np.zeros((0, 2))
        last = desired[:1] if self._last is None else self._last
        step, goes = (part[1:] for part in moving(np.concatenate([last, desired]), self._dt))
        goes[begin] = False
        unit = np.zeros((n + 1, 2))  # [0]: as it came
        unit[0] = self._unit
        unit[1:][goes] = step[goes] / np.hypot(step[goes, 0], step[goes, 1])[:, None]
        which = np.maximum.accumulate(np.where(goes, np.arange(1, n + 1), 0))
        self._last, self._unit = desired[-1:].copy(), unit[which[-1]]
        return unit[which]


def along_and_across(error: np.ndarray, heading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of an error (n, 2) along unit vectors (n, 2), ahead positive, and to their left, shapes (n,)."""
    return (
        error[:, 0] * heading[:, 0] + error[:, 1] * heading[:, 1],
        error[:, 1] * heading[:, 0] - error[:, 0] * heading[:, 1],
    )
