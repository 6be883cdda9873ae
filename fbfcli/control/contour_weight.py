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
    steps = np.diff(path.y, axis=1, append=path.y[:, -1:])
    length = np.hypot(*steps)
    moving = length > AT_REST_MM
    tx, ty = steps / np.where(moving, length, 1.0)
    less = np.where(moving, path.weight * (1.0 - wt), 0.0)  # W = g I - g (1 - wt) t t'
    return IntervalWeights(
        _means(path.weight - less * tx * tx, L, path.weight[-1]),
        _means(path.weight - less * ty * ty, L, path.weight[-1]),
        _means(-less * tx * ty, L, 0.0),
    )


def _means(w: np.ndarray, L: int, rest: float) -> np.ndarray:
    """Mean of every L samples; `rest` is what would follow the last one."""
    short = -len(w) % L
    if short:
        w = np.concatenate((w, np.full(short, rest)))
    return w.reshape(-1, L).mean(axis=1)
