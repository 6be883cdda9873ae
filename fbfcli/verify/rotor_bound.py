"""Which load angle a rotor can reach at most, for every sample and without integrating.

On a linear spring instead of a sine the rotor is a filter, phi'' = w^2 (u - phi) - 2 zeta w phi'. It swings around u
with amplitude A = |(phi - u) + i (phi' + zeta w (phi - u)) / w_d|, and until u changes it never gets further than
|u| + A. On the sine that torque needs asin(|u| + A). A load that jumps from 0 makes |u| + A twice |u|, one that turns
round three times: the magnet's own angle is less than asin of both.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from scipy.signal import cont2discrete, lfilter, ss2tf

from fbfcli.verify.rotor import Rotor


class Bound:
    """|u| + A of a rotor, from the torque that is wanted, piece by piece."""

    def __init__(self, rotor: Rotor, dt: float):
        self._w, self._zeta = rotor.w * dt, rotor.zeta
        K, drag = self._w**2, 2.0 * self._zeta * self._w
        system = (np.array([[0.0, 1.0], [-K, -drag]]), np.array([[0.0], [K]]), np.eye(2), np.zeros((2, 1)))
        self._b, self._a = ss2tf(*cont2discrete(system, 1.0, method="foh")[:4])
        self._states = [np.zeros(2), np.zeros(2)]

    def add(self, u: np.ndarray) -> np.ndarray:
        """Torque that the rotor may need until the next sample, of the standstill torque, shape (n,)."""
        phi, self._states[0] = lfilter(self._b[0], self._a, u, zi=self._states[0])
        slope, self._states[1] = lfilter(self._b[1], self._a, u, zi=self._states[1])
        away = phi - u
        swing = (slope + self._zeta * self._w * away) / (self._w * sqrt(1.0 - self._zeta**2))
        return np.asarray(np.abs(u) + np.hypot(away, swing))
