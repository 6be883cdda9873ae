"""Curves over the time of a print in a bounded number of steps: least, most and RMS of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STEPS = 1500  # about the pixels across a screen; between this and half of it are used


@dataclass(frozen=True)
class Envelope:
    """c curves in k steps of time; steps without a sample are left out.

    width     : float                  of a step [s]
    begin     : ndarray, shape (k,)    of each [s]
    low, high : ndarrays, shape (k, c)
    rms       : ndarray, shape (k, c)
    """

    width: float
    begin: np.ndarray
    low: np.ndarray
    high: np.ndarray
    rms: np.ndarray


class Enveloped:
    """Collects samples; its steps become twice as wide whenever the print has outgrown them.

    width : of the first steps [s]
    """

    def __init__(self, curves: int, width: float = 0.01):
        self._width = width
        self._count = np.zeros(STEPS, dtype=np.int64)
        self._low, self._high = np.full((STEPS, curves), np.inf), np.full((STEPS, curves), -np.inf)
        self._squares = np.zeros((STEPS, curves))

    def add(self, time: np.ndarray, x: np.ndarray) -> None:
        """More samples x, shape (n, c), at `time`, shape (n,), in any order [s]."""
        if not len(time):
            return
        while time.max() >= self._width * STEPS:
            self._widen()
        step = (time / self._width).astype(np.int64)
        if (np.diff(step) < 0).any():
            order = np.argsort(step, kind="stable")
            step, x = step[order], x[order]
        first = np.flatnonzero(np.diff(step, prepend=-1))
        here = step[first]
        self._count[here] += np.diff(np.append(first, len(step)))
        self._low[here] = np.minimum(self._low[here], np.minimum.reduceat(x, first))
        self._high[here] = np.maximum(self._high[here], np.maximum.reduceat(x, first))
        self._squares[here] += np.add.reduceat(x * x, first)

    def _widen(self) -> None:
        self._width *= 2
        none = STEPS - STEPS // 2
        self._count = np.append(self._count[::2] + self._count[1::2], np.zeros(none, dtype=np.int64))
        self._low = _padded(np.minimum(self._low[::2], self._low[1::2]), none, np.inf)
        self._high = _padded(np.maximum(self._high[::2], self._high[1::2]), none, -np.inf)
        self._squares = _padded(self._squares[::2] + self._squares[1::2], none, 0.0)

    def envelope(self) -> Envelope:
        """What was collected so far."""
        seen = np.flatnonzero(self._count)
        rms = np.sqrt(self._squares[seen] / self._count[seen, None])
        return Envelope(self._width, seen * self._width, self._low[seen], self._high[seen], rms)


def _padded(x: np.ndarray, rows: int, value: float) -> np.ndarray:
    return np.concatenate([x, np.full((rows, x.shape[1]), value)])
