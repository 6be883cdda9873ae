"""Filtered basis functions on a whole trajectory: dense least squares that reveals its rank.

Phi basis (M + 1, n + 1), G lifted plant (causal, varying, several channels), Phi_f = G Phi filtered basis,
gamma coefficients, y_d desired trajectory, u = Phi gamma command, Psi and Psi_f = G Psi decoupled functions.
Normal equations square a condition that is 1e16 for splines with n near M: nothing here forms Phi_f^T Phi_f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq, null_space, qr, solve_triangular
from scipy.signal import lfilter, lfilter_zi

from fbfcli.errors import ControlError

CONSISTENT = 1e-9  # of the terms of a condition: no contradiction, rounding on any machine


@dataclass(frozen=True)
class Controller:
    """FBF as a matrix, by its decoupled functions: C = Psi Psi_f^T, L = Psi_f Psi_f^T (Ramani 2020 Eq. E.7).

    Psi   : ndarray, shape (inputs, rank)    functions of the command
    Psi_f : ndarray, shape (outputs, rank)   the same behind the plant, orthonormal columns
    """

    Psi: np.ndarray
    Psi_f: np.ndarray

    @property
    def C(self) -> np.ndarray:
        """Lifted controller, u = C y_d."""
        return self.Psi @ self.Psi_f.T

    @property
    def L(self) -> np.ndarray:
        """Lifted overall dynamics, y = L y_d: an orthogonal projection."""
        return self.Psi_f @ self.Psi_f.T

    def command(self, y_d: np.ndarray) -> np.ndarray:
        """u = Psi (Psi_f^T y_d); a column of y_d is a trajectory."""
        return self.Psi @ (self.Psi_f.T @ y_d)

    def output(self, y_d: np.ndarray) -> np.ndarray:
        """What the nominal plant makes of the command."""
        return self.Psi_f @ (self.Psi_f.T @ y_d)


def coefficients(Phi_f: np.ndarray, y_d: np.ndarray) -> np.ndarray:
    """gamma minimising ||y_d - Phi_f gamma||, Ramani 2020 Eq. 2.10; of least norm where Phi_f is not of full rank."""
    gamma, *_ = lstsq(Phi_f, y_d, cond=_rcond(Phi_f), lapack_driver="gelsy")
    return gamma


def decoupled(Phi: np.ndarray, Phi_f: np.ndarray) -> Controller:
    """Decoupled filtered basis functions (Ramani 2020 App. E), by QR with column pivoting.

    Phi_f P = Psi_f Omega, Phi P = Psi Omega. The appendix takes Omega from a Cholesky factor of Phi_f^T Phi_f, which
    loses half the digits; columns that add nothing to the rank are dropped here, and span what the others span.
    """
    Psi_f, Omega, order = qr(Phi_f, mode="economic", pivoting=True)
    rank = int((np.abs(np.diag(Omega)) > _rcond(Phi_f) * abs(Omega[0, 0])).sum())
    Psi = solve_triangular(Omega[:rank, :rank], Phi[:, order[:rank]].T, trans="T").T
    return Controller(Psi, Psi_f[:, :rank])


def decoupled_in_order(Phi: np.ndarray, Phi_f: np.ndarray) -> Controller:
    """The same without pivoting: its first k functions serve the first k of Phi, for every k at once.

    Only for functions that are far from dependent behind the plant (cosines, not splines with n near M).
    """
    Psi_f, Omega = qr(Phi_f, mode="economic")
    diagonal = np.abs(np.diag(Omega))
    if diagonal.min() <= _rcond(Phi_f) * diagonal.max():
        raise ControlError("the filtered functions are dependent to working precision: pivot, or take fewer")
    return Controller(solve_triangular(Omega, Phi.T, trans="T").T, Psi_f)


def output_space(Phi_f: np.ndarray) -> np.ndarray:
    """Orthonormal basis of what the n + 1 filtered functions span, none dropped, shape (M + 1, n + 1).

    L = Q Q^T of exact arithmetic, whose J_e counts n + 1 functions (Ramani 2020 Prop. 2.1) even where some are zero to
    working precision; such a command could not be computed, `decoupled` says what can.
    """
    Q, _, _ = qr(Phi_f, mode="economic", pivoting=True)
    return Q


def constrained(Phi_f: np.ndarray, y_d: np.ndarray, Q: np.ndarray, z: np.ndarray) -> np.ndarray:
    """gamma minimising ||y_d - Phi_f gamma|| subject to Q gamma = z, Duan 2015 Eq. 30-31.

    What Eq. 31's multipliers give, by the null space of Q: gamma = Q^+ z + Z v with Q Z = 0.
    """
    gamma, *_ = lstsq(Q, z)
    rounding = CONSISTENT * (np.abs(Q) @ np.abs(gamma) + np.abs(z))
    if np.any(np.abs(Q @ gamma - z) > rounding):
        raise ControlError("the initial conditions contradict each other: drop one")
    Z = null_space(Q)
    return gamma + Z @ coefficients(Phi_f @ Z, y_d - Phi_f @ gamma)


def with_derivatives(parts: list[tuple[float, np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Stacked basis and target that weigh derivatives beside the position, Duan 2015 Eq. 36.

    parts : (alpha_r, filtered basis of the r-th derivative, r-th derivative of y_d), position first with alpha 1
    """
    stacked = np.concatenate([alpha * Phi_f for alpha, Phi_f, _ in parts])
    return stacked, np.concatenate([alpha * y_d for alpha, _, y_d in parts])


def filtered_from_rest(b: np.ndarray, a: np.ndarray, Phi: np.ndarray) -> np.ndarray:
    """Columns of Phi behind b / a that had rested at their first value for ever, Duan 2015 Sec. 4.1: y(0) = u(0)."""
    zi = np.outer(lfilter_zi(b, a), Phi[0])
    return lfilter(b, a, Phi, axis=0, zi=zi)[0]


def depends(Phi: np.ndarray, X: np.ndarray, G: np.ndarray, Gamma: np.ndarray) -> bool:
    """Whether filtered basis functions are linearly dependent: the rank test of Ramani 2020 Eq. 2.17, App. C.

    Phi   : ndarray, shape (inputs, n + 1)   basis
    X     : ndarray, shape (states, n + 1)   initial state that each function is filtered from
    G     : ndarray, shape (outputs, inputs) lifted plant
    Gamma : ndarray, shape (outputs, states) output of an initial state, `lifted.observability`
    """
    silent = null_space(np.hstack((G, Gamma)))  # inputs and initial states whose output is zero
    basis = np.vstack((Phi, X))
    together = np.linalg.matrix_rank(np.hstack((basis, silent)))
    return bool(together < np.linalg.matrix_rank(basis) + silent.shape[1])


def _rcond(A: np.ndarray) -> float:
    return float(np.finfo(float).eps * max(A.shape))
