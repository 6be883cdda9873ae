"""The frequency that suits a shaper best on an axis, and the one that Klipper's calibration would take.

f frequency [Hz]      zeta damping ratio      L how late the axis follows a slow command [samples]

Made for a mode, a shaper cancels that mode; where it spreads over two periods to do so, it rounds corners more than the
vibration would. Judged is a corner that nothing slows down for: an axis is told to go from rest to constant speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import freqz, lfilter

from fbfcli.control.shapers import impulses, shaper
from fbfcli.plant.model import Plant, impulse_response, modes
from fbfcli.plant.shaper_score import BAND_HZ, DAMPING, fitted

LOWEST, HIGHEST, STEP = 0.7, 2.5, 1.02  # tried are frequencies from 0.7 lowest mode to 2.5 highest, in steps of 2 %
GRID_HZ = 1.0


@dataclass(frozen=True)
class MadeFor:
    """The vibration that a shaper is made for: frequency [Hz] and damping ratio."""

    frequency: float
    damping: float


def best(name: str, plant: Plant) -> MadeFor | None:
    """What leaves least of the corner's error, with the damping of the strongest mode; None where nothing vibrates.

    Raises ModelError where the damping is beyond the shaper.
    """
    vibrations = modes(plant)
    if not vibrations:
        return None
    zeta = vibrations[0].damping
    found = [mode.frequency for mode in vibrations]
    low, high = LOWEST * min(found), HIGHEST * max(found)
    tried = low * STEP ** np.arange(np.log(high / low) / np.log(STEP))
    return min((MadeFor(float(f), zeta) for f in tried), key=lambda one: corner_error(name, one, plant))


def klippers(name: str, plant: Plant) -> MadeFor | None:
    """What Klipper's calibration takes for one of its shapers where it measures this axis; None: nothing vibrates."""
    if not modes(plant):
        return None
    f = np.arange(BAND_HZ[0], BAND_HZ[1], GRID_HZ)
    _, H = freqz(plant.b, plant.a, f, fs=1.0 / plant.dt)
    return MadeFor(fitted(name, f, f * np.abs(H) ** 2, impulses).frequency, DAMPING)


def corner_error(name: str, made_for: MadeFor, plant: Plant) -> float:
    """Root of the integral of the corner's squared error, the axis' delay taken out, per speed [s^1.5]."""
    h = impulse_response(plant)
    late = float(np.arange(len(h)) @ h)
    made = shaper(name, [(made_for.frequency, made_for.damping)], plant.dt)
    before, after = made.tail, len(h) + made.tail
    k = np.arange(-before - made.tail, after + made.lead)
    command = np.convolve(np.maximum(k, 0.0), made.taps[0], "valid")
    error = lfilter(plant.b, plant.a, command) - np.maximum(np.arange(-before, after) - late, 0.0)
    return float(np.sqrt(np.sum(error**2) * plant.dt) * plant.dt)
