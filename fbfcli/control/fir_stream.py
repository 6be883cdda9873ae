"""Commands that are a weighted sum of neighbouring desired positions, past and future, sample by sample."""

from __future__ import annotations

from typing import Protocol

import numpy as np

FEW = 12  # nonzero weights that are added one by one; more are convolved


class Fir(Protocol):
    """u[k] = sum_j taps[axis, j] y_d[k + lead - j].

    taps       : ndarray, shape (axes, lead + tail + 1)   weights, rows sum to 1
    lead, tail : samples ahead and behind that a command hears
    """

    @property
    def taps(self) -> np.ndarray: ...
    @property
    def lead(self) -> int: ...
    @property
    def tail(self) -> int: ...


class FirStream:
    """One stretch: remembers the samples that later commands still hear."""

    def __init__(self, design: Fir, y_0: np.ndarray):
        self._design, self._y_0 = design, y_0
        self._y = np.zeros((design.tail, len(y_0)))
        self._end = self._y_0  # the last desired position so far

    def under(self, design: Fir) -> FirStream:
        """A copy that goes on with another design of the same lead and tail."""
        copy = FirStream(design, self._y_0)
        copy._y, copy._end = self._y, self._end
        return copy

    def push(self, y_d: np.ndarray, weight: np.ndarray, last: bool) -> np.ndarray:
        """Commands final now, shape (m, axes) [mm]; see Stream.push. Weights are ignored."""
        lead, tail = self._design.lead, self._design.tail
        self._end = y_d[-1] if len(y_d) else self._end
        held = np.tile(self._end - self._y_0, (lead if last else 0, 1))
        y = np.concatenate((self._y, y_d - self._y_0, held))
        n = max(0, len(y) - lead - tail)
        u = np.zeros((n, y.shape[1]))
        for axis, taps in enumerate(self._design.taps if n else ()):
            u[:, axis] = _weighted(taps, y[:, axis])
        self._y = y[len(y) - lead - tail :] if n else y
        u += self._y_0
        if last and n:
            u[-1] = self._end
        return u


def _weighted(taps: np.ndarray, y: np.ndarray) -> np.ndarray:
    """sum_j taps[j] y[k - j] for every k from len(taps) - 1 on."""
    used = np.flatnonzero(taps)
    if len(used) > FEW:
        return np.convolve(y, taps, "valid")
    n = len(y) - len(taps) + 1
    u = np.zeros(n)
    for j in used:
        u += taps[j] * y[len(taps) - 1 - j : len(taps) - 1 - j + n]
    return u
