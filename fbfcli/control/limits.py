"""Commands against the machine's limits, stretch by stretch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CLIPPED = 0.2  # mm: a path along the end of the travel makes a command overshoot it by some hundredths


@dataclass(frozen=True)
class Box:
    """What a command may do. ndarrays of shape (axes,)

    low, high    : travel [mm]
    velocity     : [mm/s]
    acceleration : [mm/s^2]
    """

    low: np.ndarray
    high: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def peaks(u: np.ndarray, begin: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Largest |u'| and |u''| of each axis in each stretch, shape (s, axes) each.

    u     : ndarray, shape (n, axes)      stretches one after the other
    begin : ndarray of int, shape (s,)    their first samples; begin[0] = 0
    """
    velocity = np.empty((len(begin), u.shape[1]))
    acceleration = np.empty_like(velocity)
    for axis in range(u.shape[1]):
        step = np.diff(u[:, axis], append=u[-1:, axis])
        step[begin[1:] - 1] = 0.0  # from one stretch to the next
        bend = np.diff(step, prepend=step[0])
        bend[begin[1:]] = 0.0
        bend[begin[1:] - 1] = 0.0
        bend[-1] = 0.0
        velocity[:, axis] = np.maximum.reduceat(np.abs(step), begin) / dt
        acceleration[:, axis] = np.maximum.reduceat(np.abs(bend), begin) / (dt * dt)
    return velocity, acceleration


def outside(u: np.ndarray, y_d: np.ndarray, begin: np.ndarray, dt: float, box: Box) -> np.ndarray:
    """Stretches whose command leaves the box although the desired motion stays within it, bool, shape (s,).

    Where the desired motion itself is outside (a planner's corner steps), the command may not be worse. Positions
    beyond the travel by less than CLIPPED do not count: see `clip`.
    """
    velocity, acceleration = peaks(u, begin, dt)
    v_desired, a_desired = peaks(y_d, begin, dt)
    bad = (velocity > np.maximum(box.velocity, v_desired)) | (acceleration > np.maximum(box.acceleration, a_desired))
    for axis in range(u.shape[1]):
        bad[:, axis] |= np.minimum.reduceat(u[:, axis], begin) < box.low[axis] - CLIPPED
        bad[:, axis] |= np.maximum.reduceat(u[:, axis], begin) > box.high[axis] + CLIPPED
    return bad.any(axis=1)


def clip(u: np.ndarray, box: Box) -> np.ndarray:
    """The command, shape (n, axes), held at the ends of the travel where it would overshoot them."""
    return np.clip(u, box.low, box.high)
