"""Corners of a desired path: where it turns sharply, and how."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.verify.contour_error import stride_of
from fbfcli.verify.heading import Heading

SHARP = np.cos(np.radians(20.0))  # directions 2 ms apart that differ by more are a corner
PARALLEL = 0.17  # sine of a turn that has no outside: almost straight back


@dataclass(frozen=True)
class Corners:
    """c corners among n samples.

    first, last : ndarray of int, shape (c,)   the last sample that goes as it came, the first that goes as it will
    point       : ndarray, shape (c, 2)        where the lines before and after meet [mm]
    outward     : ndarray, shape (c, 2)        unit vector: across the path behind, to the outside of the turn; straight
                                               on where the path comes straight back
    left        : ndarray, shape (c, 2)        unit vector to the left of the path behind
    turn        : ndarray, shape (c,)          [rad], 0 to pi
    """

    first: np.ndarray
    last: np.ndarray
    point: np.ndarray
    outward: np.ndarray
    left: np.ndarray
    turn: np.ndarray

    def __len__(self) -> int:
        return len(self.first)

    def __getitem__(self, rows: slice | np.ndarray) -> Corners:
        return Corners(self.first[rows], self.last[rows], self.point[rows], self.outward[rows], self.left[rows],
                       self.turn[rows])  # fmt: skip


def corners(desired: np.ndarray, begin: np.ndarray, dt: float) -> Corners:
    """Corners of a path (n, 2) whose pieces begin at `begin` (s,): there is none where one does."""
    n, stride = len(desired), stride_of(dt)
    heading = Heading(dt).follow(desired, begin)
    apart = 2 * stride
    sharp = np.zeros(n, dtype=bool)
    if n > apart:
        dot = (heading[apart:] * heading[:-apart]).sum(axis=1)
        sharp[apart:] = (dot < SHARP) & (heading[:-apart] != 0.0).any(axis=1)
    broken = np.cumsum(np.bincount(begin, minlength=n)[:n])
    sharp[apart:] &= broken[apart:] == broken[: max(n - apart, 0)]
    edge = np.diff(sharp.astype(np.int8), prepend=0, append=0)
    last = np.minimum(np.flatnonzero(edge < 0) - 1, n - 1)
    first = np.flatnonzero(edge > 0) - 1  # the sample before the direction changes
    last = np.maximum(last - apart + 1, first + 1)
    first = np.maximum(first - stride, 0)  # a sample may lie on both sides: its direction is neither
    last = np.minimum(last + stride, n - 1)
    before, after = heading[first], heading[last]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    dot = (before * after).sum(axis=1)
    left = np.column_stack([-after[:, 1], after[:, 0]])
    back = np.abs(cross) < PARALLEL
    outward = np.where(back[:, None], before, -np.sign(cross)[:, None] * left)
    return Corners(first, last, _meeting(desired, first, last, before, after, cross), outward, left,
                   np.abs(np.arctan2(cross, dot)))  # fmt: skip


def _meeting(desired: np.ndarray, first: np.ndarray, last: np.ndarray, before: np.ndarray, after: np.ndarray,
             cross: np.ndarray) -> np.ndarray:  # fmt: skip
    """Where the line through the sample before goes through that after; of almost parallel ones the first sample."""
    a, gap = desired[first], desired[last] - desired[first]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (gap[:, 0] * after[:, 1] - gap[:, 1] * after[:, 0]) / cross
    reach = 2.0 * np.hypot(gap[:, 0], gap[:, 1])
    s = np.where(np.isfinite(s) & (np.abs(cross) >= PARALLEL), np.clip(s, 0.0, reach), 0.0)
    return a + s[:, None] * before
