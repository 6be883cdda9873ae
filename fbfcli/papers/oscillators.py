"""The uncertain oscillator of Ramani 2020, chapter 4, and the FBF controllers that are compared on it.

G(s) = w^2 / (s^2 + 2 zeta w s + w^2) behind a zero-order hold at 1 kHz (Eq. 4.1): 41 frequencies, evenly spaced, times
10 damping ratios, evenly spaced in their logarithm, equally probable. M + 1 samples, n + 1 functions, r = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fbfcli.control.bases import dct
from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.fbf import Controller, decoupled, decoupled_in_order
from fbfcli.control.lifted import causal
from fbfcli.control.lifted_robust import Family, lti_family
from fbfcli.control.optimal_basis import RobustBasis, effort_optimal, robust_basis

M, R, DEGREE = 1000, 1, 5
DT = 1e-3  # s
SIZES = range(10, 991, 10)  # n
NAMES = ("DCT", "B-splines", "CE-Opt", "robust")
NOMINALS = ("standard", "proposed")


def oscillator(frequency: np.ndarray, zeta: np.ndarray) -> np.ndarray:
    """Markov parameters behind a zero-order hold, frequency [Hz], shape (J, M + 1): steps of the step response."""
    w = 2 * np.pi * frequency[:, None]
    damped = np.sqrt(1 - zeta[:, None] ** 2)
    t = DT * np.arange(M + 1)
    swing = np.cos(w * damped * t) + zeta[:, None] / damped * np.sin(w * damped * t)
    step = 1 - np.exp(-zeta[:, None] * w * t) * swing
    return np.diff(step, axis=1, prepend=0)


def realisations() -> np.ndarray:
    """The 410 plants that may be, shape (410, M + 1)."""
    frequency, zeta = np.meshgrid(np.linspace(180, 220, 41), np.geomspace(1e-3, 1e-1, 10))
    return oscillator(frequency.ravel(), zeta.ravel())


@dataclass(frozen=True)
class Nominal:
    """A nominal plant and what rests on it.

    G      : ndarray, shape (M + 1, M + 1)
    robust : RobustBasis     of every size
    nested : per basis but B-splines, a Controller whose first n + 1 functions serve every n
    """

    G: np.ndarray
    robust: RobustBasis
    nested: dict[str, Controller]

    def controller(self, name: str, n: int) -> Controller:
        """FBF with n + 1 functions of a basis; a spline's functions change with their number."""
        if name == "B-splines":
            Phi = bsplines(normalised_time(M), n, DEGREE)
            return decoupled(Phi, self.G @ Phi)
        whole = self.nested[name]
        return Controller(whole.Psi[:, : n + 1], whole.Psi_f[:, : n + 1])


@cache
def plants() -> Family:
    """The 410 plants' moments."""
    g = realisations()
    return lti_family(g, np.full(len(g), 1 / len(g)))


@cache
def nominal(which: str) -> Nominal:
    """Standard: 200 Hz, damping 0.01 (Eq. 4.1). Proposed: the optimal nominal model (Eq. 4.28)."""
    if which == "standard":
        G = causal(oscillator(np.array([200.0]), np.array([0.01]))[0])
    else:
        G = plants().optimal_nominal()
    cosines = dct(M, SIZES[-1])
    robust = robust_basis(G, plants().root(G), R)
    nested = {
        "DCT": decoupled_in_order(cosines, G @ cosines),
        "CE-Opt": effort_optimal(G, SIZES[-1]),
        "robust": robust.controller(SIZES[-1]),
    }
    return Nominal(G, robust, nested)
