"""Robust filters: what basis functions are filtered by when the plant is one of a family (Ramani 2020b, Sec. III).

G (J, n) responses of the family on a frequency grid, f (J,) their probabilities, G_r (n,) the robust filter
r magnitude and theta phase of the plant, each between bounds (dynamic uncertainty, Eq. 17)
Rational filters are coefficients b, a of z^0, z^-1, ...
"""

from __future__ import annotations

import numpy as np

from fbfcli.errors import ModelError


def robust_filter(G: np.ndarray, f: np.ndarray) -> np.ndarray:
    """G_r = E[G G*] / E[G*], the inverse of the controller of least expected error, Ramani 2020b Eq. 11.

    G : complex ndarray, shape (J, n)   frequency responses of the family
    f : ndarray, shape (J,)             probability of each, sum 1

    Where the family's mean is zero there is no such controller and G_r is infinite.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((f @ np.abs(G) ** 2) / (f @ G.conj()))


def first_order_filter(a_nom: float, a_d: float, p: float) -> tuple[np.ndarray, np.ndarray]:
    """b, a of G_r for (z - a) / (z - p), a uniform in a_nom +- a_d, Ramani 2020b Eq. 13.

    G_r = (z^2 - (a_nom + 1 / a_nom + a_d^2 / (3 a_nom)) z + 1) / ((z - p) (z - 1 / a_nom)), unstable for |a_nom| < 1:
    see split_filter. Raises ModelError for a_nom = 0, where E[G*] has no zero to invert.
    """
    if a_nom == 0.0:
        raise ModelError("the robust filter of Eq. 13 is not defined for a nominal zero at 0")
    middle = a_nom + 1 / a_nom + a_d**2 / (3 * a_nom)
    return np.array([1.0, -middle, 1.0]), np.poly([p, 1 / a_nom])


def gain_modulation(a_nom: float, a_d: float) -> tuple[np.ndarray, np.ndarray]:
    """b, a of alpha = G_r / G_nom = (z^2 - (...) z + 1) / ((z - a_nom) (z - 1 / a_nom)), Ramani 2020b Eq. 16.

    On the unit circle it is real and not less than 1: its poles and its zeros mirror each other.
    """
    b, a = first_order_filter(a_nom, a_d, a_nom)
    return b, a


def worst_case_filter(r: tuple[np.ndarray, np.ndarray], theta: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """G_r of the controller whose largest |1 - C G| over the bounds is least (Wu & Zou 2009), Ramani 2020b Remark 3.

    r, theta : (least, largest) magnitude and phase [rad], ndarrays of shape (n,)

    With C = alpha e^(-j theta_mid) and half a range of phase theta_d, |1 - C G|^2 is greatest at phase theta_d and at
    an end of r: max over r of 1 - 2 alpha r cos(theta_d) + (alpha r)^2. The ends balance where
        alpha (r_min + r_max) = 2 cos(theta_d)
    Infinite (no command at all is best) where the phase is not known to within a quarter turn.
    """
    half = (theta[1] - theta[0]) / 2
    gain = np.where(half < np.pi / 2, (r[0] + r[1]) / (2 * np.cos(np.minimum(half, 1.5))), np.inf)
    return np.asarray(gain * np.exp(0.5j * (theta[0] + theta[1])))


def worst_case_modulation(
    G_nom: np.ndarray, r: tuple[np.ndarray, np.ndarray], theta: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """The same with the given nominal phase: G_r = G_nom / alpha, alpha real (a gain modulated inversion)."""
    nominal = np.angle(G_nom * np.exp(-0.5j * (theta[0] + theta[1]))) + 0.5 * (theta[0] + theta[1])
    off = np.maximum(theta[1] - nominal, nominal - theta[0])
    return worst_case_filter(r, (nominal - off, nominal + off))
