"""Lifted system representation: a system over samples 0..M as the matrix that takes its inputs to its outputs.

g Markov parameters (impulse response), G lifted plant, C lifted controller, E lifted error dynamics, y = G u.
Signals of several channels are stacked sample by sample: u = [u(0); u(1); ...], each u(k) a vector.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.linalg import toeplitz
from scipy.signal import lfilter

StateSpace = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # A (s, s), B (s, p), C (o, s), D (o, p)


def markov(b: np.ndarray, a: np.ndarray, M: int) -> np.ndarray:
    """Markov parameters g_0..g_M of b / a (coefficients of z^0, z^-1, ...), Ramani 2020 Eq. A.1."""
    return lfilter(b, a, np.eye(1, M + 1)[0])


def causal(g: np.ndarray) -> np.ndarray:
    """LSR of a causal LTI system: lower triangular Toeplitz, Ramani 2020 Eq. A.2."""
    return toeplitz(g, np.zeros(len(g)))


def non_causal(c: np.ndarray, origin: int, M: int) -> np.ndarray:
    """LSR of an LTI system whose response is c[origin] at lag 0, shape (M + 1, M + 1), Ramani 2020 Eq. A.4."""
    column, row = np.zeros(M + 1), np.zeros(M + 1)
    past, future = c[origin : origin + M + 1], c[origin::-1][: M + 1]
    column[: len(past)] = past
    row[: len(future)] = future
    return toeplitz(column, row)


def mimo(channels: list[list[np.ndarray]]) -> np.ndarray:
    """LSR of several channels, channels[o][p] (M + 1, M + 1) the LSR from input p to output o; samples interleaved."""
    stacked = np.array(channels)
    outputs, inputs, rows, columns = stacked.shape
    return stacked.transpose(2, 0, 3, 1).reshape(rows * outputs, columns * inputs)


def varying(systems: Iterable[StateSpace]) -> np.ndarray:
    """LSR of a linear system whose matrices change from sample to sample (LTV; LPV along a known schedule).

    x(k+1) = A_k x(k) + B_k u(k), y(k) = C_k x(k) + D_k u(k), x(0) = 0. Row k of the result is C_k X_k plus D_k on the
    diagonal, where X_k takes all inputs to x(k); the system's own recursion is the one loop over samples.
    """
    systems = list(systems)
    states, (outputs, inputs) = len(systems[0][0]), systems[0][3].shape
    G = np.zeros((len(systems) * outputs, len(systems) * inputs))
    X = np.zeros((states, len(systems) * inputs))
    for k, (A, B, C, D) in enumerate(systems):
        now = slice(k * inputs, (k + 1) * inputs)
        row = slice(k * outputs, (k + 1) * outputs)
        G[row] = C @ X
        G[row, now] += D
        X = A @ X
        X[:, now] += B
    return G


def observability(A: np.ndarray, C: np.ndarray, M: int) -> np.ndarray:
    """[C; C A; ...; C A^M]: the output that an initial state gives without input, Ramani 2020 Eq. 2.14."""
    rows = [C]
    for _ in range(M):
        rows.append(rows[-1] @ A)
    return np.concatenate(rows)


def metric(E: np.ndarray) -> float:
    """J = ||E||_F / sqrt(M + 1): J_e of error dynamics (Ramani 2020 Eq. 2.18), J_c of a controller (Eq. 3.4)."""
    return float(np.linalg.norm(E) / np.sqrt(len(E)))


def bound(C: np.ndarray) -> float:
    """Greatest output of a lifted system per greatest input: its infinity norm, Ramani 2020 Eq. B.4, B.5."""
    return float(np.abs(C).sum(axis=1).max())


def decoupled_bound(Psi: np.ndarray, Psi_f: np.ndarray) -> float:
    """A bound on ||Psi Psi_f^T||_inf by the decoupled functions one by one, Ramani 2020 Eq. B.9, B.10."""
    return float((np.abs(Psi).max(axis=0) * np.abs(Psi_f).sum(axis=0)).sum())
