"""Bases that are best for one plant: least effort (CE-Opt), least effect of a known uncertainty, and their size.

G = V Sigma W^T lifted plant, M + 1 samples, n + 1 functions, r smallest singular values kept out of the command,
J_e accuracy of n + 1 functions of any kind, Delta^T Delta spread of the family about the nominal plant.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.linalg import svd

from fbfcli.control.fbf import Controller
from fbfcli.errors import ControlError


def accuracy(n: int, M: int) -> float:
    """J_e = sqrt(1 - (n + 1) / (M + 1)) of any n + 1 functions behind any plant, Ramani 2020 Eq. 2.21."""
    return float(np.sqrt(1 - (n + 1) / (M + 1)))


def size_for(J_e: float, M: int) -> int:
    """Least n whose accuracy is J_e or better: Eq. 2.21 solved for n, the first stage of Ramani 2020 Remark 3.2."""
    if not 0 <= J_e < 1:
        raise ControlError(f"an accuracy J_e is 0 (perfect) or more, and less than 1 (no control), not {J_e:g}")
    exact = (1 - J_e**2) * (M + 1) - 1
    return max(0, ceil(exact - 1e-9 * (M + 1)))  # J_e that came from a whole n is met by that n, rounding or not


def effort_optimal(G: np.ndarray, n: int) -> Controller:
    """CE-Opt: Psi_i = w_i / sigma_i, Psi_f,i = v_i of the n + 1 largest singular values, Ramani 2020 Eq. 3.22."""
    _fits(G, n, 0)
    V, sigma, Wt = svd(G)
    return Controller(Wt[: n + 1].T / sigma[: n + 1], V[:, : n + 1])


def effort_optimal_weighted(G: np.ndarray, F: np.ndarray, n: int) -> Controller:
    """CE-Opt where the lifted filter F tells what matters of a trajectory, Ramani 2020 Remark 3.3.

    The dynamics are premultiplied by F: the functions are those of F G, and the command minimises ||F (y_d - G u)||.
    Psi_f belongs to F G, so the controller takes F y_d.
    """
    return effort_optimal(F @ G, n)


def least_effort(sigma: np.ndarray, n: int) -> float:
    """J_c of CE-Opt from the plant's singular values, largest first, Ramani 2020 Eq. 3.23."""
    return float(np.sqrt((1 / sigma[: n + 1] ** 2).sum() / len(sigma)))


@dataclass(frozen=True)
class RobustBasis:
    """Robust basis functions of every size at once, Ramani 2020 Prop. 4.2.

    Psi   : ndarray, shape (M + 1, M + 1 - r)   functions, most robust first: the best n + 1 are the first n + 1
    Psi_f : ndarray, shape (M + 1, M + 1 - r)   the same behind the nominal plant, orthonormal
    sigma : ndarray, shape (M + 1 - r,)         what the uncertainty does to each, ascending
    """

    Psi: np.ndarray
    Psi_f: np.ndarray
    sigma: np.ndarray

    def controller(self, n: int) -> Controller:
        """FBF with the n + 1 most robust functions."""
        if not 0 <= n < len(self.sigma):
            raise ControlError(f"{n + 1} robust functions: there are {len(self.sigma)}")
        return Controller(self.Psi[:, : n + 1], self.Psi_f[:, : n + 1])

    def best_size(self) -> int:
        """n of least J_e,r: as long as a function's singular value is below 1 it is worth having, Remark 4.5."""
        return max(0, int((self.sigma < 1).sum()) - 1)

    def metric(self, n: int) -> float:
        """J_e,r of the first n + 1 functions, Ramani 2020 Eq. 4.24."""
        M = len(self.Psi) - 1
        return float(np.sqrt(1 - (n + 1) / (M + 1) + (self.sigma[: n + 1] ** 2).sum() / (M + 1)))


def robust_basis(G_nom: np.ndarray, Delta: np.ndarray, r: int) -> RobustBasis:
    """Functions that the uncertainty disturbs least, without the plant's r smallest singular values, Eq. 4.22.

    Delta : ndarray, shape (M + 1, M + 1)   a root of the family's spread, `lifted_robust.Family.spread`
    """
    _fits(G_nom, 0, r)
    kept = len(G_nom) - r
    V, s, Wt = svd(G_nom)
    inverse = Wt[:kept].T / s[:kept]  # W Sigma^-1 without its last r columns
    _, sigma, turn = svd(Delta @ inverse, full_matrices=False)
    Xi = turn[::-1].T  # right singular vectors, smallest singular value first
    return RobustBasis(inverse @ Xi, V[:, :kept] @ Xi, sigma[::-1])


def _fits(G: np.ndarray, n: int, r: int) -> None:
    if r < 0 or n < 0 or n >= min(G.shape) - r:
        raise ControlError(f"{n + 1} functions of a lifted plant {G.shape} without its {r} smallest singular values")
