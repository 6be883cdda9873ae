"""What a resonance test commands: acceleration that is constant or a chirp, piece by piece.

a : acceleration [mm/s^2]     f : frequency [Hz]     c : sweep rate [Hz/s]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sweep:
    """The command of one test, at rest before 0 and after `duration`.

    name     : of the test, for people
    duration : [s]
    f0, f1   : lowest and highest frequency of the sweep [Hz]
    velocity : velocity [mm/s] at times [s] (any shape); the command's exact first integral, so that an average
               acceleration over any interval is a difference
    markers  : times at which synchronisation pulses begin [s]
    segments : (begin, end) [s] of stretches of one amplitude each [mm/s^2] (begin, end, amplitude)
    """

    name: str
    duration: float
    f0: float
    f1: float
    velocity: Callable[[np.ndarray], np.ndarray]
    markers: tuple[float, ...] = ()
    segments: tuple[tuple[float, float, float], ...] = ()


def acceleration(sweep: Sweep, t: np.ndarray, width: float) -> np.ndarray:
    """Mean acceleration over `width` [s] around each time, shape of t [mm/s^2]."""
    return (sweep.velocity(t + 0.5 * width) - sweep.velocity(t - 0.5 * width)) / width
