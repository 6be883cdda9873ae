"""Normal equations of the contour-weighted problem, for the knot intervals over which a family of plants holds.

With the Gram tensors G of `contour_gram`, A_xx[i, i + d] = sum_s wxx[i + s] Gx[s, d] and so on: a product with the
Hankel matrix of the weights. Coefficients of X and Y are interleaved in a band by columns: T[2i, 2d] = xx,
T[2i, 2d + 1] = xy, T[2i + 1, 2d] = yy, T[2i + 1, 2d - 1] = yx. The right-hand side meets the mean splines with W y.
"""

from __future__ import annotations

import numpy as np

from fbfcli.control.contour_gram import ContourGram
from fbfcli.control.contour_weight import IntervalWeights
from fbfcli.control.projection import projected

LAGS = 24  # columns of a product: what it skips against what it takes to begin


def add_band(T: np.ndarray, gram: ContourGram, w: IntervalWeights, first: int, earliest: int) -> None:
    """Add what coefficients make of the intervals first, first + 1, ... whose weights w holds.

    T        : ndarray, shape (2 n, 2 S)   band from coefficient `earliest` <= 0 on
    earliest : coefficients are counted like intervals: i begins with interval i
    """
    S, last = len(gram.xx), earliest + len(T) // 2
    low, high = max(earliest, first - S + 1), min(last, first + len(w.xx))
    if low >= high:
        return
    rows = T[2 * (low - earliest) : 2 * (high - earliest)]
    xx, yy, xy = (_hankel(each, high - low, S, first - low) for each in w)
    for d in range(0, S, LAGS):  # G[s, d] is zero for s < d
        lags, even = slice(d, min(d + LAGS, S)), slice(2 * d, 2 * min(d + LAGS, S), 2)
        odd = slice(even.start + 1, even.stop, 2)
        rows[0::2, even] += xx[:, d:] @ gram.xx[d:, lags]
        rows[0::2, odd] += xy[:, d:] @ gram.xy[d:, lags]
        rows[1::2, even] += yy[:, d:] @ gram.yy[d:, lags]
        rows[1::2, odd] += xy[:, d:] @ gram.yx[d:, lags]


def add_right(r: np.ndarray, gram: ContourGram, w: IntervalWeights, Y: np.ndarray, first: int) -> None:
    """Add the same to the right-hand side r, shape (n, 2), of the coefficients from 0 on.

    Y : ndarray, shape (2, k, L)   desired positions of those intervals
    """
    low, high = max(0, first - len(gram.xx) + 1), min(len(r), first + len(w.xx))
    if low >= high:
        return
    before = np.zeros((first - low, Y.shape[2]))
    for axis, (a, b) in enumerate(((w.xx, w.xy), (w.xy, w.yy))):
        z = np.concatenate((before, a[:, None] * Y[0] + b[:, None] * Y[1]))
        r[low:high, axis] += projected(gram.mean[axis], z, high - low)


def _hankel(w: np.ndarray, n: int, S: int, ahead: int) -> np.ndarray:
    """H[i, s] = w[i + s - ahead], zero outside w; shape (n, S)."""
    padded = np.zeros(n + S - 1)
    count = min(len(w), len(padded) - ahead)
    padded[ahead : ahead + count] = w[:count]
    step = padded.itemsize
    return np.ndarray((n, S), float, padded, 0, (step, step)).copy()  # copied: BLAS takes no overlapping rows
