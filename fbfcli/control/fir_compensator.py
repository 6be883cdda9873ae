"""Commands that are a weighted sum of neighbouring desired positions, past and future, sample by sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbfcli.control.compensator import Stream

FEW = 12  # nonzero weights that are added one by one; more are convolved


@dataclass(frozen=True)
class FirCompensator:
    """u[k] = sum_j taps[axis, j] y_d[k + lead - j].

    taps       : ndarray, shape (axes, lead + tail + 1)   weights, rows sum to 1
    lead, tail : hold a stretch needs at its start and end, for its command to start and end at rest [samples]
    harder     : makes a gentler one of the same lead and tail; None where there is none
    """

    name: str
    taps: np.ndarray
    lead: int
    tail: int
    harder: Callable[[], FirCompensator] | None = None

    settle = notice = 0

    @property
    def preview(self) -> int:
        """Samples ahead that a command depends on."""
        return self.lead

    def start(self, y_0: np.ndarray) -> FirStream:
        """A stretch that rests at y_0, shape (axes,) [mm], before it."""
        return FirStream(self, np.array(y_0, float))

    def resume(self, stream: Stream) -> FirStream:
        """The same stretch from where it is, with these weights."""
        if not isinstance(stream, FirStream):
            raise TypeError("another method's stretch")
        return stream.under(self)

    def stiffer(self) -> FirCompensator | None:
        """The gentler one, if there is one."""
        return self.harder() if self.harder else None


class FirStream:
    """One stretch: remembers the samples that later commands still hear."""

    def __init__(self, design: FirCompensator, y_0: np.ndarray):
        self._design, self._y_0 = design, y_0
        self._y = np.zeros((design.tail, len(y_0)))
        self._end = self._y_0  # the last desired position so far

    def under(self, design: FirCompensator) -> FirStream:
        """A copy that goes on with another design; one of another length waits for the next stretch."""
        fits = (design.lead, design.tail) == (self._design.lead, self._design.tail)
        copy = FirStream(design if fits else self._design, self._y_0)
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
