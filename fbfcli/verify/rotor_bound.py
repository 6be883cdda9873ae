"""What torque a rotor takes, its own swinging included, for every sample and without integrating.

On a linear spring instead of a sine the rotor is a filter, phi'' = w^2 (u - phi) - 2 zeta w phi', and phi is the torque
that the field gives it, of the standstill torque. Between samples u is linear, so

    [phi, phi'](t) = exp(A t) [phi, phi'](0) + the same integrated over u

is exact at any fraction of a period. The load angle that gives this torque on the sine is asin(phi): twice what a load
takes at rest where it jumps, three times where it turns round. The rotor's own load angle is less in both.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from scipy.linalg import expm
from scipy.signal import cont2discrete, lfilter, ss2tf

from fbfcli.verify.rotor import Rotor

APART = 0.4  # rad of the rotor's own oscillation between two looks: a peak between them is 2 % higher


class Bound:
    """Torque that a linear rotor takes, from the torque that is wanted of it, piece by piece."""

    def __init__(self, rotor: Rotor, dt: float):
        w, zeta = rotor.w * dt, rotor.zeta
        A, B = np.array([[0.0, 1.0], [-(w**2), -2.0 * zeta * w]]), np.array([[0.0], [w**2]])
        self._b, self._a = ss2tf(*cont2discrete((A, B, np.eye(2), np.zeros((2, 1))), 1.0, method="foh")[:4])
        self._states = [np.zeros(2), np.zeros(2)]
        self._last = np.zeros((3, 1))  # phi, phi' and u of the last sample
        looks = ceil(w / APART)
        whole = np.zeros((4, 4))  # phi, phi', u and its slope
        whole[:2, :2], whole[:2, 2:3], whole[2, 3] = A, B, 1.0
        self._between = [expm(whole * j / looks)[0] for j in range(1, looks)]

    def add(self, u: np.ndarray) -> np.ndarray:
        """The largest torque since the sample before, of the standstill torque, shape (n,)."""
        phi, self._states[0] = lfilter(self._b[0], self._a, u, zi=self._states[0])
        slope, self._states[1] = lfilter(self._b[1], self._a, u, zi=self._states[1])
        here = np.concatenate([self._last, [phi, slope, u]], axis=1)
        self._last = here[:, -1:]
        largest = np.abs(phi)
        for row in self._between:
            between = row[:3] @ here[:, :-1]
            between += row[3] * np.diff(here[2])
            np.maximum(largest, np.abs(between), out=largest)
        return largest
