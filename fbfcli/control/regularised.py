"""Regularised FBF for plants with bounded random uncertainty: a game between the coefficients and the plant.

Phi basis, Phi_f = G_nom Phi, u = Phi gamma, e = y_d - Phi_f gamma; the plant is G_nom + D, all of D that is known is
||D||_2 <= delta. Ramani 2020b [27] (Ramani & Okwudire 2016) is described there as coefficients of least error against
the worst plant, from coupled nonlinear equations; its own equations are not in the papers at hand, so this is the game
as the description states it, solved as Sayed, Nascimento & Chandrasekaran (1998) solve bounded data uncertainty:
    min over gamma, max over D of ||y_d - (G_nom + D) Phi gamma|| = min over gamma of ||e|| + delta ||u||
The worst D turns u into the direction of -e. Where neither e nor u vanishes the minimum is at
    (Phi_f^T Phi_f + alpha Phi^T Phi) gamma = Phi_f^T y_d,    alpha = delta ||e|| / ||u||        (coupled through alpha)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular, svd
from scipy.optimize import brentq

from fbfcli.errors import ControlError

LARGEST = 1e16  # alpha over the largest squared singular value: the command has vanished before


@dataclass(frozen=True)
class Regularised:
    """The game's solution.

    gamma : ndarray, shape (n + 1,)   coefficients
    alpha : float                     weight on ||u||^2 that they amount to; infinite where u = 0 is best
    worst : float                     largest error norm over the plants: ||e|| + delta ||u||
    """

    gamma: np.ndarray
    alpha: float
    worst: float


def regularised(Phi: np.ndarray, Phi_f: np.ndarray, y_d: np.ndarray, delta: float) -> Regularised:
    """gamma of least worst error for a bound delta on the plant's uncertainty.

    With Phi = Q R and v = R gamma: u = Q v has the norm of v and Phi_f gamma = A v. The singular values s of
    A = U S V^T and c = U^T y_d leave one equation in alpha: alpha ||v|| = delta ||e|| with v = s c / (s^2 + alpha).
    """
    if delta < 0:
        raise ControlError(f"a bound on uncertainty is not negative: {delta:g}")
    R = qr(Phi, mode="r")[0][: Phi.shape[1]]
    if np.abs(np.diag(R)).min() < np.finfo(float).eps * max(Phi.shape) * np.abs(R[0, 0]):
        raise ControlError("the basis functions are linearly dependent: take fewer, or orthonormal ones")
    A = solve_triangular(R, Phi_f.T, trans="T").T
    U, s, Vt = svd(A, full_matrices=False)
    c = U.T @ y_d
    left = max(0.0, float(y_d @ y_d - c @ c))  # of ||e||^2 that no command reaches
    alpha = _balance(s, c, left, delta)
    v = s * c / (s**2 + alpha) if np.isfinite(alpha) else np.zeros_like(c)
    gamma = solve_triangular(R, Vt.T @ v)
    worst = float(np.linalg.norm(y_d - Phi_f @ gamma) + delta * np.linalg.norm(v))
    return Regularised(gamma, alpha, worst)


def _balance(s: np.ndarray, c: np.ndarray, left: float, delta: float) -> float:
    """alpha with alpha ||v|| = delta ||e||; 0 where the exact solution is best, infinite where no command is."""

    def excess(log_alpha: float) -> float:
        alpha = np.exp(log_alpha)
        v, e = s * c / (s**2 + alpha), alpha * c / (s**2 + alpha)
        return float(alpha * np.linalg.norm(v) - delta * np.sqrt(e @ e + left))

    if delta == 0.0:
        return 0.0
    if delta * np.sqrt(c @ c + left) >= np.linalg.norm(s * c):  # even the first bit of command costs more than it gains
        return float("inf")
    low, high = np.log(s[-1] ** 2 / LARGEST + np.finfo(float).tiny), np.log(s[0] ** 2 * LARGEST)
    if excess(low) >= 0:
        return 0.0
    return float(np.exp(brentq(excess, low, high, xtol=1e-13, rtol=1e-13)))
