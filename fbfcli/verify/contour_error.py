"""Contour error: how far the nozzle is from the desired path, wherever along it.

The nearest point is searched in time around the sample itself, first coarsely, then among the neighbouring segments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PERIOD = 1e-3  # s between the points of a path that the search is made for; paths sampled finer are searched in strides
REACH = 64  # periods: the nozzle is never later or earlier on its path than this
COARSE = 4  # periods between the points of the first search


def stride_of(dt: float) -> int:
    """Samples per PERIOD, at least 1."""
    return max(round(PERIOD / dt), 1)


def reach(dt: float) -> int:
    """Samples of path that are searched on either side of a sample."""
    return REACH * stride_of(dt)


def contour_error(
    actual: np.ndarray, desired: np.ndarray, at: np.ndarray, first: np.ndarray, last: np.ndarray, dt: float = PERIOD
) -> np.ndarray:
    """Distance of `actual[at]` from the desired path [mm], shape (k,).

    actual, desired : ndarray, shape (n, 2)   nozzle and path, sampled together [mm]
    at              : ndarray of int, (k,)    samples to look at
    first, last     : ndarray of int, (k,)    the stretch each of them belongs to
    dt              : float                   period of the samples [s]

    A point d away from its own sample has its nearest path point within 2 d of that sample: where the path goes further
    than that in COARSE periods, the first search is left out.
    """
    stride = stride_of(dt)
    coarse = COARSE * stride
    px, py = np.ascontiguousarray(desired[:, 0]), np.ascontiguousarray(desired[:, 1])
    qx, qy = actual[at, 0], actual[at, 1]
    centre = at.copy()
    way = np.minimum(
        _squared(px, py, px[at], py[at], np.maximum(at - coarse, first)),
        _squared(px, py, px[at], py[at], np.minimum(at + coarse, last)),
    )
    nearest = _squared(px, py, qx, qy, at)
    far = np.flatnonzero(4.0 * nearest > way)
    if len(far):
        shifts = range(-reach(dt), reach(dt) + 1, coarse)
        centre[far] = _nearest(px, py, qx[far], qy[far], at[far], first[far], last[far], shifts)
    if stride > 1:
        centre = _nearest(px, py, qx, qy, centre, first, last, range(-coarse, coarse + 1, stride))
    fine = COARSE if stride == 1 else stride
    for shift in range(-fine, fine):
        k = np.clip(centre + shift, first, np.maximum(last - 1, first))
        np.minimum(nearest, _to_segment(px, py, qx, qy, k, np.minimum(k + 1, last)), out=nearest)
    return np.sqrt(nearest)


def _nearest(
    px: np.ndarray, py: np.ndarray, qx: np.ndarray, qy: np.ndarray, at: np.ndarray, first: np.ndarray,
    last: np.ndarray, shifts: range,
) -> np.ndarray:  # fmt: skip
    """Sample of the nearest of the path points that are so many samples away."""
    best = at.copy()
    nearest = _squared(px, py, qx, qy, at)
    for shift in shifts:
        k = np.clip(at + shift, first, last)
        distance = _squared(px, py, qx, qy, k)
        closer = distance < nearest
        np.copyto(nearest, distance, where=closer)
        np.copyto(best, k, where=closer)
    return best


def _squared(px: np.ndarray, py: np.ndarray, qx: np.ndarray, qy: np.ndarray, k: np.ndarray) -> np.ndarray:
    dx, dy = px[k] - qx, py[k] - qy
    return dx * dx + dy * dy


def _to_segment(
    px: np.ndarray, py: np.ndarray, qx: np.ndarray, qy: np.ndarray, k: np.ndarray, j: np.ndarray
) -> np.ndarray:
    """Squared distance of each q from the segment between path points k and j."""
    ax, ay = px[k], py[k]
    sx, sy = px[j] - ax, py[j] - ay
    rx, ry = qx - ax, qy - ay
    length = sx * sx + sy * sy
    t = np.clip((rx * sx + ry * sy) / np.maximum(length, 1e-30), 0.0, 1.0)
    dx, dy = rx - t * sx, ry - t * sy
    return dx * dx + dy * dy


@dataclass(frozen=True)
class Errors:
    """Errors of positions [um]."""

    rms: float
    p99: float
    max: float


class ErrorTally:
    """RMS, 99th percentile and maximum of errors that arrive in pieces, in bounded memory."""

    BIN_MM = 1e-4  # resolution of the percentile
    BINS = 50_000

    def __init__(self) -> None:
        self._count, self._squares, self._max = 0, 0.0, 0.0
        self._bins = np.zeros(self.BINS, dtype=np.int64)

    def add(self, error: np.ndarray) -> None:
        """Count more errors [mm], shape (n,)."""
        if len(error):
            self._count += len(error)
            self._squares += float(error @ error)
            self._max = max(self._max, float(error.max()))
            self._bins += np.bincount(
                np.minimum(error / self.BIN_MM, self.BINS - 1).astype(np.int64), minlength=self.BINS
            )

    def figures(self) -> dict[str, float]:
        """The three figures [um], or zeros where nothing was counted."""
        if not self._count:
            return {"rms": 0.0, "p99": 0.0, "max": 0.0}
        p99 = (int(np.searchsorted(np.cumsum(self._bins), 0.99 * self._count)) + 1) * self.BIN_MM
        return {
            "rms": 1e3 * (self._squares / self._count) ** 0.5,
            "p99": 1e3 * min(p99, self._max),
            "max": 1e3 * self._max,
        }
