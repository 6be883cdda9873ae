"""Microsteps: the positions that a motor's field can take."""

from __future__ import annotations

import numpy as np

from fbfcli.printer import Motor

INTERPOLATED = 256  # microsteps of a full step that an interpolating drive makes (Trinamic: intpol, MicroPlyer)


def quantised(q: np.ndarray, steps_per_mm: float) -> np.ndarray:
    """The microsteps nearest to positions q [mm], any shape: off by half a microstep at most."""
    return np.rint(q * steps_per_mm) / steps_per_mm


def finest(motor: Motor) -> int:
    """Positions of the field in a full step."""
    return INTERPOLATED if motor.interpolation else motor.microsteps
