"""Figures of many groups of values (layers, features) in little memory: percentiles come from logarithmic bins."""

from __future__ import annotations

import numpy as np

LOWEST, HIGHEST = 1e-5, 1e2  # mm: a hundredth of a micrometre, longer than any wave on a part
RATIO = 1.05  # of neighbouring bins: how exact a percentile is, a little better for the interpolation
BINS = int(np.ceil(np.log(HIGHEST / LOWEST) / np.log(RATIO))) + 1


class LogBins:
    """Values, none negative, of groups that are numbered from 0; 1.3 kB a group."""

    def __init__(self) -> None:
        self._bins = np.zeros((0, BINS), dtype=np.uint32)
        self._squares, self._max = np.zeros(0), np.zeros(0)

    def add(self, group: np.ndarray, value: np.ndarray) -> None:
        """Count more values, shape (n,), of groups (n,)."""
        if not len(value):
            return
        low, high = int(group.min()), int(group.max())
        self._grow(high + 1)
        here, many = group - low, high + 1 - low
        with np.errstate(divide="ignore"):
            place = np.log(value / LOWEST) / np.log(RATIO)
        place = np.clip(place, 0, BINS - 1).astype(np.int64)
        self._bins[low : high + 1] += (
            np.bincount(here * BINS + place, minlength=many * BINS).reshape(many, BINS).astype(np.uint32)
        )
        self._squares[low : high + 1] += np.bincount(here, value * value, many)
        np.maximum.at(self._max, group, value)

    @property
    def count(self) -> np.ndarray:
        """Values of each group, shape (g,)."""
        return np.asarray(self._bins.sum(axis=1, dtype=np.int64))

    @property
    def rms(self) -> np.ndarray:
        """Shape (g,); 0 where nothing was counted."""
        return np.sqrt(self._squares / np.maximum(self.count, 1))

    @property
    def max(self) -> np.ndarray:
        """Shape (g,)."""
        return self._max.copy()

    def quantile(self, q: float) -> np.ndarray:
        """The value that a part q of each group does not exceed, shape (g,)."""
        upto = np.cumsum(self._bins, axis=1, dtype=np.int64)
        wanted = q * upto[:, -1:]
        at = np.minimum((upto < wanted).sum(axis=1), BINS - 1)
        row = np.arange(len(at))
        before = np.where(at > 0, upto[row, at - 1], 0)
        inside = (wanted[:, 0] - before) / np.maximum(self._bins[row, at], 1)
        value = np.where(at > 0, LOWEST * RATIO ** (at + np.clip(inside, 0.0, 1.0)), self._max)
        return np.minimum(value, self._max)

    def all(self) -> LogBins:
        """Every group together, as group 0."""
        one = LogBins()
        if len(self._max):
            one._bins, one._squares = self._bins.sum(axis=0, keepdims=True), self._squares.sum(keepdims=True)
            one._max = self._max.max(keepdims=True)
        return one

    def _grow(self, groups: int) -> None:
        missing = groups - len(self._max)
        if missing > 0:
            missing = max(missing, len(self._max))  # twice as many: layers come one by one
            self._bins = np.concatenate([self._bins, np.zeros((missing, BINS), dtype=np.uint32)])
            self._squares, self._max = (np.append(each, np.zeros(missing)) for each in (self._squares, self._max))
