"""How much an error matters, by its direction: across the path fully, along it little.

W_k = g_k (n n' + wt t t'), t the path's direction at sample k, n normal to it, g_k the sample's weight; g_k I at rest
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fbfcli.control.path import Path

AT_REST_MM = 1e-6  # per sample: slower than any motion, faster than rounding


class IntervalWeights(NamedTuple):
    """Means of W over each of N knot intervals, ndarrays of shape (N,)."""

    xx: np.ndarray
    yy: np.ndarray
    xy: np.ndarray


def interval_weights(path: Path, L: int, wt: float) -> IntervalWeights:
    """Of the path's whole intervals and, where the path ends within one, of that too: it rests from there on."""
    n, g = len(path.weight), path.weight
    dx, dy = np.diff(path.y, axis=1, append=path.y[:, -1:])
    squared = dx * dx + dy * dy
    moving = squared > AT_REST_MM**2
    less = np.where(moving, (1.0 - wt) * g, 0.0) / np.where(moving, squared, 1.0)  # W = g I - g (1 - wt) t t'
    W = np.zeros((3, -(-n // L) * L))
    W[:2] = g[-1]
    W[0, :n] = g - less * dx * dx
    W[1, :n] = g - less * dy * dy
    W[2, :n] = -less * dx * dy
    return IntervalWeights(*(W.reshape(3, -1, L) @ np.full(L, 1.0 / L)))
