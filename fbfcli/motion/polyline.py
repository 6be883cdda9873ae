"""Node values of the piecewise linear curve that a firmware makes of G1 lines: hat functions, fitted by least squares.

    P      hat functions, one column per node: P gamma is the curve through node values gamma
    u      command at every sample
    G      plant: what the nozzle makes of a command

`fit` minimises ||u - P gamma||; it halves the RMS of nodes taken from the curve. Where a firmware takes too few
segments for that to be small, `fit_through` minimises ||G (u - P gamma)||, the error of the nozzle: filtered basis
functions (Ramani 2020, Eq. 2.10) with hat functions as the basis, by conjugate gradients preconditioned with P^T P.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.signal import lfilter

NEAR = 0.2  # weight of staying at the command: a node that the nozzle hardly feels must not wander
ITERATIONS = 3  # of the conjugate gradients: five more make the error of the nozzle a twentieth smaller


class Polyline:
    """Hat functions on nodes.

    nodes  : ndarray of int, shape (m,)     samples, increasing; nodes[0] = 0
    pinned : ndarray of bool, shape (m,)    nodes that keep the command's value
    """

    def __init__(self, nodes: np.ndarray, pinned: np.ndarray):
        self.nodes, self.pinned = nodes, pinned
        self._length = np.diff(nodes)
        self._theta = np.arange(nodes[-1]) - np.repeat(nodes[:-1], self._length)  # place in a segment, 0 to 1
        self._theta = self._theta / np.repeat(self._length, self._length)

    def curve(self, values: np.ndarray) -> np.ndarray:
        """P values: the curve through the node values (m,) at every sample, shape (n,)."""
        out = np.empty(self.nodes[-1] + 1)
        np.multiply(np.repeat(np.diff(values), self._length), self._theta, out=out[:-1])
        out[:-1] += np.repeat(values[:-1], self._length)
        out[-1] = values[-1]
        return out

    def onto_hats(self, samples: np.ndarray) -> np.ndarray:
        """P^T samples, shape (m,), zero at pinned nodes."""
        right = np.add.reduceat(samples[:-1] * self._theta, self.nodes[:-1])
        out = np.append(np.add.reduceat(samples[:-1], self.nodes[:-1]) - right, samples[-1])
        out[1:] += right
        out[self.pinned] = 0.0
        return out

    def nearest(self, samples: np.ndarray) -> np.ndarray:
        """Node values whose curve is nearest to the samples (n,), zero at pinned nodes, shape (m,)."""
        return self.solve(self.onto_hats(samples))

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """(P^T P)^-1 rhs over the nodes that are not pinned; rhs is zero at those that are."""
        return cho_solve_banded(self._factor, rhs, check_finite=False)

    @cached_property
    def _factor(self) -> tuple[np.ndarray, bool]:
        """Cholesky factor of P^T P, upper band."""
        return cholesky_banded(self._gram(), check_finite=False), False

    def _gram(self) -> np.ndarray:
        """P^T P, upper band, pinned nodes apart. Sums of theta and theta^2 over a segment have closed forms."""
        length = self._length.astype(float)
        theta2 = (length - 1) * (2 * length - 1) / (6 * length)  # its last sample excluded
        theta1 = (length - 1) / 2
        band = np.zeros((2, len(self.nodes)))
        band[1, :-1] = length - 2 * theta1 + theta2
        band[1, 1:] += theta2
        band[1, -1] += 1.0
        band[0, 1:] = np.where(self.pinned[1:] | self.pinned[:-1], 0.0, theta1 - theta2)
        band[1, self.pinned] = 1.0
        return band


def fit(u: np.ndarray, polyline: Polyline) -> np.ndarray:
    """Node values, shape (m, axes), whose curve is nearest to the command u, shape (n, axes)."""
    values = u[polyline.nodes].copy()
    for axis in range(u.shape[1]):
        values[:, axis] += polyline.nearest(u[:, axis] - polyline.curve(values[:, axis]))
    return values


def fit_through(
    values: np.ndarray, u: np.ndarray, polyline: Polyline, plants: Sequence[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """Node values, shape (m, axes), whose curve moves the nozzle as the command would; from those of `fit`.

    plants : (b, a) of each axis, coefficients of z^-1
    """
    values = values.copy()
    for axis, (b, a) in enumerate(plants):
        error = u[:, axis] - polyline.curve(values[:, axis])
        values[:, axis] += _through(error, polyline, b, a)
    return values


def _through(error: np.ndarray, polyline: Polyline, b: np.ndarray, a: np.ndarray) -> np.ndarray:
    """delta minimising ||G (error - P delta)||^2 + NEAR ||P delta||^2, shape (m,), ITERATIONS steps from 0."""

    def normal(curve: np.ndarray) -> np.ndarray:
        """P^T (G^T G + NEAR) curve; `error` itself has no part along P."""
        return polyline.onto_hats(lfilter(b, a, lfilter(b, a, curve)[::-1])[::-1] + NEAR * curve)

    delta = np.zeros(len(polyline.nodes))
    r = normal(error)
    z = polyline.solve(r)
    p, rz = z, float(r @ z)
    for _ in range(ITERATIONS):
        if rz <= 0.0:
            break
        Ap = normal(polyline.curve(p))
        step = rz / float(p @ Ap)
        delta += step * p
        r = r - step * Ap
        z = polyline.solve(r)
        rz, before = float(r @ z), rz
        p = z + (rz / before) * p
    return delta
