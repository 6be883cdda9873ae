"""A family of plants in the lifted domain: its moments, its spread about a nominal plant, and the best nominal plant.

G_aj what the plant may be, lambda_j weights with sum 1, G_nom what the basis is filtered by, y_d white or given.
All that FBF's expected error needs of a family are E[G] and E[G^T G]: 410 plants cost as much as one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, pinv

from fbfcli.control.fbf import Controller
from fbfcli.control.lifted import causal
from fbfcli.errors import ControlError

RCOND = 1e-13  # of Eq. 4.28's pseudo-inverse: below it a singular value is the rounding of a zero outside the circle


@dataclass(frozen=True)
class Family:
    """The first two moments of a family of lifted plants.

    mean   : ndarray, shape (M + 1, M + 1)   sum lambda_j G_aj
    second : ndarray, shape (M + 1, M + 1)   sum lambda_j G_aj^T G_aj
    """

    mean: np.ndarray
    second: np.ndarray

    def spread(self, G_nom: np.ndarray) -> np.ndarray:
        """Delta^T Delta = sum lambda_j (G_aj - G_nom)^T (G_aj - G_nom), Ramani 2020 Eq. 4.14."""
        cross = self.mean.T @ G_nom
        return self.second - cross - cross.T + G_nom.T @ G_nom

    def root(self, G_nom: np.ndarray) -> np.ndarray:
        """A Delta of that spread."""
        values, vectors = eigh(self.spread(G_nom))
        return np.sqrt(np.maximum(values, 0))[:, None] * vectors.T

    def optimal_nominal(self, rcond: float = RCOND) -> np.ndarray:
        """G_nom = (sum lambda_j G_aj^T)^+ (sum lambda_j G_aj^T G_aj), Ramani 2020 Eq. 4.28."""
        return pinv(self.mean.T, rtol=rcond) @ self.second

    def metric(self, controller: Controller) -> float:
        """J_e,r = sqrt(E ||I - G_aj C||_F^2 / (M + 1)) of any FBF controller, Ramani 2020 Eq. 4.2.

        ||I - G C||_F^2 = M + 1 - 2 tr(G C) + ||G C||_F^2 with C = Psi Psi_f^T, Psi_f orthonormal.
        """
        Psi, Psi_f = controller.Psi, controller.Psi_f
        through = (Psi_f * (self.mean @ Psi)).sum()
        energy = (Psi * (self.second @ Psi)).sum()
        size = len(self.mean)
        return float(np.sqrt(1 + (energy - 2 * through) / size))

    def nested_metrics(self, controller: Controller) -> np.ndarray:
        """J_e,r of the first 1, 2, ... of a controller's functions, shape (rank,)."""
        Psi, Psi_f = controller.Psi, controller.Psi_f
        through = (Psi_f * (self.mean @ Psi)).sum(axis=0)
        energy = (Psi * (self.second @ Psi)).sum(axis=0)
        return np.sqrt(1 + np.cumsum(energy - 2 * through) / len(self.mean))


def family(G: np.ndarray, weights: np.ndarray) -> Family:
    """Of any lifted plants (varying, several channels), G (J, outputs, inputs)."""
    if len(G) != len(weights) or not np.isclose(weights.sum(), 1):
        raise ControlError(f"{len(G)} plants need as many weights, sum 1, not {len(weights)} with {weights.sum():g}")
    return Family(np.tensordot(weights, G, 1), sum(w * each.T @ each for w, each in zip(weights, G, strict=True)))


def lti_family(g: np.ndarray, weights: np.ndarray) -> Family:
    """Of causal LTI plants by their Markov parameters, g (J, M + 1).

    (G^T G)_ij = sum_{k >= max(i, j)} g_{k-i} g_{k-j}: a running sum down each diagonal of the outer products, from the
    last sample up.
    """
    second = (g.T * weights) @ g
    for i in range(1, len(second)):  # row i adds to the diagonal what row i - 1 has summed
        second[i, 1:] += second[i - 1, :-1]
    return Family(causal(weights @ g), np.ascontiguousarray(second[::-1, ::-1]))
