"""Samples of a streamed path that wait until there is path on both sides of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Rows = tuple[np.ndarray, ...]


@dataclass(frozen=True)
class Ready:
    """Samples that can be measured, among others around them.

    rows  : tuple of ndarray, shapes (n, ...)   the columns of all of them
    at    : slice                               those that are ready, each given out once
    begin : ndarray of int, shape (s,)          samples at which a stretch begins or goes on; the first is 0
    """

    rows: Rows
    at: slice
    begin: np.ndarray

    def stretch(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and last sample of the stretch that each of `at` (k,) belongs to, shapes (k,)."""
        return stretch_ends(at, self.begin, len(self.rows[0]))


class HeldBack:
    """Columns of a path, fed piece by piece; the last `reach` samples of a stretch that goes on are held back."""

    def __init__(self, reach: int):
        self._reach = reach
        self._open: Rows | None = None  # the last samples of a stretch that goes on
        self._given = 0  # those of them that are given out already

    def add(self, rows: Rows, begin: np.ndarray, goes_on: bool) -> Ready:
        """More samples, stretches of which begin at `begin` (s,); `goes_on`: the last one is not at its end."""
        before = 0
        if self._open is not None:
            before = len(self._open[0])
            rows = tuple(np.concatenate(column) for column in zip(self._open, rows, strict=True))
        n, given = len(rows[0]), self._given
        begin = np.union1d([0], begin + before)
        ready = max(n - self._reach, int(begin[-1]), given) if goes_on else n
        keep = max(int(begin[-1]), ready - self._reach)
        self._open, self._given = (tuple(column[keep:] for column in rows), ready - keep) if goes_on else (None, 0)
        return Ready(rows, slice(given, ready), begin)

    def rest(self) -> Ready | None:
        """What is still held back; no more will come."""
        if self._open is None:
            return None
        return self.add(tuple(column[:0] for column in self._open), np.zeros(0, dtype=np.int64), goes_on=False)


def stretch_ends(at: np.ndarray, begin: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """First and last of n samples of the stretch that each of `at` (k,) belongs to, if they begin at `begin` (s,)."""
    stretch = np.searchsorted(begin, at, side="right") - 1
    return begin[stretch], np.append(begin[1:], n)[stretch] - 1
