"""Our own sweep: swings to and fro from rest to rest, so that any planner makes a square wave of acceleration of them.

d : length of a swing [mm]     a : acceleration [mm/s^2]     T : its duration [s]     f : frequency [Hz]
A swing speeds up over d/2 and brakes over d/2: T = 2 sqrt(d / a), and two of them are a period: f = 1 / (2 T).
Acceleration stays the same while f rises, so that machines that behave otherwise when shaken harder are seen to do so:
there is a sweep for each of several accelerations (2 to 5 m/s^2 in Ramani et al. 2020b, Fig. 4).

Before the first and after the last sweep a marker swings out and back, as Ulendo's does. In between the machine creeps
instead of pausing: a dwell (G4) has no exact length in Marlin and RepRapFirmware, a slow move has.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

CREEP_V, CREEP_S = 0.6, 1.0  # mm/s, s: slower than RepRapFirmware moves at all (0.5 mm/s) must not be
MARKER_S = 0.05  # s of acceleration, out; back takes twice that
PEAK = 0.9  # of the highest speed that may be reached


@dataclass(frozen=True)
class SweepSettings:
    """What is to be swept.

    f0, f1        : lowest and highest frequency [Hz]
    rate          : by which it rises [Hz/s]
    accelerations : one sweep for each, lowest first [mm/s^2]
    velocity      : highest that may be reached [mm/s]
    shortest      : swing that the firmware executes [mm]
    """

    f0: float
    f1: float
    rate: float
    accelerations: tuple[float, ...]
    velocity: float
    shortest: float


@dataclass(frozen=True)
class Swings:
    """Swings from rest to rest, n of them, in order; each turns back.

    distance     : ndarray, shape (n,)   signed [mm]
    acceleration : ndarray, shape (n,)   [mm/s^2]
    speed        : ndarray, shape (n,)   asked for; the swing itself stays below it, a creep reaches it [mm/s]
    part         : ndarray of int        0: creep or marker; 1, 2, ...: of which sweep
    """

    distance: np.ndarray
    acceleration: np.ndarray
    speed: np.ndarray
    part: np.ndarray

    def __len__(self) -> int:
        return len(self.distance)


def frequencies_of(settings: SweepSettings, a: float) -> tuple[float, float]:
    """First and last frequency at acceleration `a`: limited by the speed below and by the shortest swing above.

    At f the speed reaches a / (4 f) and a swing is a / (16 f^2) long.
    """
    return max(settings.f0, a / (4 * PEAK * settings.velocity)), min(settings.f1, sqrt(a / settings.shortest) / 4)


def swings(settings: SweepSettings) -> Swings:
    """Marker, sweeps, marker, with a creep before and after each."""
    v = settings.velocity
    hardest = max(settings.accelerations)
    out = min(MARKER_S, PEAK * v / hardest)
    marker = np.full(2, hardest * out**2)
    creep = np.array([CREEP_V * CREEP_S])
    blocks = [(creep, 0), (marker, 0), (creep, 0)]
    for number, a in enumerate(settings.accelerations, 1):
        f = half_periods(*frequencies_of(settings, a), settings.rate)
        blocks += [(a / (16 * f**2), number), (creep, 0)]
    blocks += [(marker, 0), (creep, 0)]
    distance = np.concatenate([block for block, _ in blocks])
    part = np.concatenate([np.full(len(block), number) for block, number in blocks])
    speed = np.where(distance == creep[0], CREEP_V, v)
    acceleration = np.array([hardest, *settings.accelerations])[part]
    return Swings(distance * np.where(np.arange(len(distance)) % 2, -1.0, 1.0), acceleration, speed, part)


def half_periods(f0: float, f1: float, rate: float) -> np.ndarray:
    """f of each swing while f rises by `rate`: half a period at f raises it by rate / (2 f), so f^2 rises evenly."""
    return np.sqrt(np.arange(f0**2, f1**2 + rate, rate))
