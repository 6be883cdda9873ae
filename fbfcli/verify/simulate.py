"""The plant driven by a command: where the nozzle goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter, oaconvolve

LONG = 64  # coefficients of a finite response from which transforms are faster
REST_SAMPLES = 500  # a longer rest between stretches changes nothing: the vibration has gone


class Nozzle:
    """Positions of a vibrating printer, fed with its command piece by piece.

    b_a : one (b, a) per axis, coefficients of z^-1 with unit DC gain
    """

    def __init__(self, b_a: Sequence[tuple[np.ndarray, np.ndarray]]):
        self._b_a = b_a
        self._state = [np.zeros(max(len(b), len(a)) - 1) for b, a in b_a]
        self._last: np.ndarray | None = None  # last command
        self._moved = np.zeros(len(b_a))  # where the plant rested, plus moves made outside stretches

    def follow(self, command: np.ndarray, begin: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """Nozzle positions for more of the command, shape (n, axes).

        command : ndarray, shape (n, axes)      [mm]
        begin   : ndarray of int, shape (s,)    samples at which a stretch begins; before the first the last one goes on
        rest    : ndarray of int, shape (s,)    samples of rest before each of them

        With unit DC gain, a displacement between stretches moves the whole plant: it is taken out and put back.
        """
        if self._last is None:
            self._last, self._moved = command[0].copy(), command[0].copy()
        previous = np.where(begin[:, None] > 0, command[begin - 1], self._last)
        moved = self._moved + np.concatenate(
            [np.zeros((1, command.shape[1])), np.cumsum(command[begin] - previous, axis=0)]
        )
        length = np.diff(begin, prepend=0, append=len(command))
        counts = np.ones(len(command), dtype=np.int64)
        counts[begin] += np.minimum(rest, REST_SAMPLES)
        where = np.cumsum(counts) - 1
        out = np.empty(command.shape, order="F")
        for axis, (b, a) in enumerate(self._b_a):
            shift = np.repeat(moved[:, axis], length)
            u = np.repeat(command[:, axis] - shift, counts)
            y, self._state[axis] = _filtered(b, a, u, self._state[axis])
            np.add(y[where], shift, out=out[:, axis])
        self._last, self._moved = command[-1].copy(), moved[-1]
        return out


def _filtered(b: np.ndarray, a: np.ndarray, u: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`lfilter` with its state; long finite responses by overlapping transforms."""
    if len(a) > 1 or len(b) < LONG:
        return lfilter(b, a, u, zi=state)
    y = oaconvolve(u, b / a[0])
    y[: len(state)] += state
    return y[: len(u)], y[len(u) :]
