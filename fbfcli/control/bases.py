"""Bases of finite trajectories: each a matrix Phi whose n + 1 columns are the functions at samples 0..M.

Splines have a file of their own, control/bspline.py; bases that know the plant are in control/optimal_basis.py.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from fbfcli.errors import ControlError


def dct(M: int, n: int) -> np.ndarray:
    """Cosines, orthonormal, shape (M + 1, n + 1), Ramani 2020 Eq. F.1."""
    _check(M, n)
    k, i = np.arange(M + 1)[:, None], np.arange(n + 1)
    beta = np.where(i == 0, 1.0, np.sqrt(2.0)) / np.sqrt(M + 1)
    return beta * np.cos(np.pi * (2 * k + 1) * i / (2 * (M + 1)))


def block_pulses(M: int, n: int) -> np.ndarray:
    """Pulses of unit norm that share the samples as evenly as whole samples allow, shape (M + 1, n + 1)."""
    _check(M, n)
    edges = np.arange(n + 2) * (M + 1) // (n + 1)
    width = np.diff(edges)
    Phi = np.zeros((M + 1, n + 1))
    Phi[np.arange(M + 1), np.repeat(np.arange(n + 1), width)] = np.repeat(1 / np.sqrt(width), width)
    return Phi


def laguerre(M: int, n: int, pole: float) -> np.ndarray:
    """Impulse responses of L_i(q) = sqrt(1 - p^2) / (1 - p q^-1) ((q^-1 - p) / (1 - p q^-1))^i, shape (M + 1, n + 1).

    Orthonormal on 0..infinity for |p| < 1 (Wahlberg 1991, Eq. 4); on 0..M as far as they have died away.
    """
    _check(M, n)
    if not -1 < pole < 1:
        raise ControlError(f"Laguerre functions need a pole inside the unit circle, not {pole:g}")
    Phi = np.empty((n + 1, M + 1))
    impulse = np.zeros(M + 1)
    impulse[0] = np.sqrt(1 - pole**2)
    Phi[0] = lfilter([1.0], [1.0, -pole], impulse)
    for i in range(n):
        Phi[i + 1] = lfilter([-pole, 1.0], [1.0, -pole], Phi[i])
    return Phi.T


def _check(M: int, n: int) -> None:
    if not 0 <= n <= M:
        raise ControlError(f"{n + 1} functions on {M + 1} samples: take 1 to {M + 1}")
