"""What a resonance test commands: the velocity of one axis, exactly, at any time.

a : acceleration [mm/s^2]     v : velocity [mm/s]     f : frequency [Hz]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Sweep:
    """The command of one test, at rest before 0 and after `duration`.

    name     : of the test, for people
    duration : [s]
    f0, f1   : lowest and highest frequency of the sweep [Hz]
    velocity : velocity [mm/s] at times [s] (any shape); the exact integral of the acceleration, so that a mean
               acceleration over any interval is a difference
    segments : (begin, end, amplitude) of stretches of one amplitude each [s, s, mm/s^2]; empty: one stretch
    open_end : it is the beginning of a longer sweep: what comes after `duration` is not known
    scalable : its amplitude is the firmware's default, which people change
    """

    name: str
    duration: float
    f0: float
    f1: float
    velocity: Callable[[np.ndarray], np.ndarray]
    segments: tuple[tuple[float, float, float], ...] = ()
    open_end: bool = False
    scalable: bool = False


def acceleration(sweep: Sweep, t: np.ndarray, width: float) -> np.ndarray:
    """Mean acceleration over `width` [s] around each time, shape of t [mm/s^2].

    A sampled square wave needs the mean: values at the sampling times alone would move each edge to a sample.
    """
    return np.asarray((sweep.velocity(t + 0.5 * width) - sweep.velocity(t - 0.5 * width)) / width)


def piecewise(length: np.ndarray, a: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Velocity of constant accelerations `a`, shape (m,), one after the other for `length` [s] each; 0 outside."""
    edge = np.concatenate([[0.0], np.cumsum(length)])
    v = np.concatenate([[0.0], np.cumsum(length * a)])
    return lambda t: np.interp(t, edge, v, left=0.0, right=0.0)


def until(sweep: Sweep, end: float) -> Sweep:
    """A sweep whose frequency rises evenly, up to `end` [s]; from there on it coasts: a stop would be a blow."""
    if end >= sweep.duration:
        return sweep
    whole = sweep.velocity
    f1 = sweep.f0 + (sweep.f1 - sweep.f0) * end / sweep.duration
    return replace(sweep, duration=end, f1=f1, velocity=lambda t: whole(np.minimum(t, end)))
