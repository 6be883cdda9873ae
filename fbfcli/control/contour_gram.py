"""What the family of plants says about pairs of splines: the Gram tensor of the contour-weighted problem.

A filtered spline f_j = h_j * beta of plant j is cut at the knots into fm_j, shape (S, L). Over one knot interval the
squared response of two splines that began s and s - d intervals ago is P[s, s - d] with
    P = sum_j lambda_j fm_j fm_j',    Pxy = mean(fm_x) mean(fm_y)'
so that with one weight per interval b, A[i, i + d] = sum_s w[i + s] G[s, d], G[s, d] = P[s, s - d]: a product of
matrices whose size depends neither on the family's size nor on the plants' order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.basis import Basis
from fbfcli.control.truncated import truncated


@dataclass(frozen=True)
class ContourGram:
    """Two axes' families, as their splines see them.

    mean : two ndarrays, shape (S, L)              mean filtered splines of X and Y
    xx, yy, xy : ndarray, shape (S, S)             G[s, d], zero for d > s; of xy the later spline is Y's
    yx         : ndarray, shape (S, S)             G[s, d + 1], the later spline X's: the band holds its lag 0 as xy's
    """

    mean: tuple[np.ndarray, np.ndarray]
    xx: np.ndarray
    yy: np.ndarray
    xy: np.ndarray
    yx: np.ndarray


def contour_gram(basis: Basis, x: AxisModel, y: AxisModel) -> ContourGram:
    """The tensor of two axes."""
    filtered = [[np.convolve(truncated(h), basis.beta) for h in axis.family] for axis in (x, y)]
    S = max(-(-len(f) // basis.L) for family in filtered for f in family)
    fm = [np.zeros((len(family), S, basis.L)) for family in filtered]
    for pieces, family in zip(fm, filtered, strict=True):
        for rows, f in zip(pieces.reshape(len(family), -1), family, strict=True):
            rows[: len(f)] = f
    mean_x, mean_y = (np.tensordot(axis.weights, each, 1) for axis, each in zip((x, y), fm, strict=True))
    xx, yy = (_mean_product(axis.weights, each) for axis, each in zip((x, y), fm, strict=True))
    cross = mean_x @ mean_y.T
    return ContourGram((mean_x, mean_y), _by_lag(xx), _by_lag(yy), _by_lag(cross),
                       np.roll(_by_lag(cross.T), -1, axis=1) * (np.arange(S) < S - 1))  # fmt: skip


def _mean_product(weights: np.ndarray, fm: np.ndarray) -> np.ndarray:
    """P = sum_j lambda_j fm_j fm_j', shape (S, S)."""
    return np.asarray(np.tensordot(weights, fm @ fm.transpose(0, 2, 1), 1))


def _by_lag(P: np.ndarray) -> np.ndarray:
    """G[s, d] = P[s, s - d] for s >= d, else zero."""
    s, d = np.indices(P.shape)
    return np.where(s >= d, P[s, s - d], 0.0)
