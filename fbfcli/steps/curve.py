"""Position between samples: a curve that is continuous in speed and never leaves its samples' range.

y samples one period apart, d = y[k+1] - y[k], s slope at a sample [per period]. The slope is the central difference,
limited to twice the smaller neighbour (van Leer 1977, the monotonized central limiter), 0 at a turning point. Between
two samples stand two parabolas that meet in the middle (Schumaker 1983), where the slope is 2 d - (s[k] + s[k+1]) / 2:
it has the sign of d, so the curve turns at samples only. A constant acceleration is met exactly.
"""

from __future__ import annotations

import numpy as np


def slopes(y: np.ndarray) -> np.ndarray:
    """Slope at each inner sample, shape (n - 2,)."""
    d = np.diff(y)
    left, right = d[:-1], d[1:]
    size = np.abs(d)
    most = 2.0 * np.minimum(size[:-1], size[1:])
    most[left * right <= 0.0] = 0.0
    return np.clip(0.5 * (left + right), -most, most)


def middle(y: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and slope halfway between neighbours, shape (n - 1,) each; y, s : shape (n,)."""
    d = np.diff(y)
    slope = 2.0 * d - 0.5 * (s[:-1] + s[1:])
    return y[:-1] + 0.25 * (s[:-1] + slope), slope


def position(y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The curve's position at fractional sample numbers `at`, 0 to n - 1; it rests before the first and after the last.

    y : ndarray, shape (n,) or (n, columns)
    """
    if y.ndim == 2:
        return np.column_stack([position(column, at) for column in y.T])
    s = slopes(np.concatenate([y[:1], y, y[-1:]]))
    y_mid, s_mid = middle(y, s)
    k = np.minimum(at.astype(np.int64), len(y) - 2)
    tau = at - k
    late = tau >= 0.5
    tau = np.where(late, tau - 0.5, tau)
    y_0, s_0 = np.where(late, y_mid[k], y[k]), np.where(late, s_mid[k], s[k])
    s_1 = np.where(late, s[k + 1], s_mid[k])
    return y_0 + tau * (s_0 + tau * (s_1 - s_0))
