"""What torque a stepper has left at speed.

Of a phase: V supply, R resistance, L inductance, I current (RMS); T_h holding torque, both phases at the rated current
I_r; p rotor teeth, w speed of the shaft [rad/s], K = T_h / (sqrt(2) I_r) torque and voltage constant [N m/A, V s/rad].

The drive forces its sinusoidal current while its voltage suffices: torque K sqrt(2) I = T_h I / I_r. Above that speed
the current is what the supply's amplitude drives against back-EMF E = K w and impedance Z = sqrt(R^2 + (p w L)^2). With
the phasor V at the best angle its part across the rotor's flux is V / Z - E R / Z^2, so

    T(w) = min(T_h I / I_r, K (V Z - E R) / Z^2) - T_detent

Acarnley, Stepping Motors: a guide to theory and practice, derives the second term as the hybrid motor's pull-out
torque. The detent torque alternates; all of it is taken off. Iron loss, saturation and resonance are left out.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from fbfcli.printer import Motor

LEAST = 1e-3  # of the standstill torque: beyond the last speed a motor can reach, so that loads stay finite


def standstill_torque(motor: Motor) -> float:
    """Torque at rest with the run current [N m]."""
    return motor.holding_torque * motor.run_current / motor.rated_current - motor.detent_torque


def torque_left(motor: Motor, w: np.ndarray) -> np.ndarray:
    """T(w) as a share of the standstill torque, LEAST to 1, for speeds of the shaft w [rad/s], any shape."""
    K = motor.holding_torque / (sqrt(2.0) * motor.rated_current)
    w = np.abs(w)
    Z2 = motor.resistance**2 + (0.25 * motor.full_steps * w * motor.inductance) ** 2
    torque = K * (motor.supply_voltage * np.sqrt(Z2) - K * w * motor.resistance) / Z2 - motor.detent_torque
    return np.clip(torque / standstill_torque(motor), LEAST, 1.0)
