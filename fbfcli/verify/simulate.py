"""The plant driven by a command: where the nozzle goes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import lfilter, oaconvolve

from fbfcli.plant.model import BA

LONG = 64  # coefficients of a finite response from which transforms are faster
REST_SAMPLES = 500  # a longer rest between stretches changes nothing: the vibration has gone
MEMORY = 1000  # samples that a plant has heard when the print comes to the place where it holds

Coupling = Sequence[BA | None]


class Nozzle:
    """Positions of a vibrating printer, fed with its command piece by piece.

    plants   : one (b, a) per axis, coefficients of z^-1 with unit DC gain; of a printer whose plants change along the
               print, what gives them for a place
    coupling : of each of two axes, (b, a) without DC gain: what the other's command adds to it; None: nothing
    """

    def __init__(self, plants: Sequence[BA] | Callable[[int], Sequence[BA]], coupling: Coupling = (None, None)):
        self._at = plants if callable(plants) else lambda place: plants
        self._coupled = [(axis, _Coupled(ba)) for axis, ba in enumerate(coupling) if ba is not None]
        self._axes = [_Vibrating() for _ in self._at(0)]
        self._last: np.ndarray | None = None  # last command
        self._moved = np.zeros(len(self._axes))  # where the plant rested, plus moves made outside stretches

    def follow(self, command: np.ndarray, begin: np.ndarray, rest: np.ndarray,
               place: np.ndarray | None = None) -> np.ndarray:  # fmt: skip
        """Nozzle positions for more of the command, shape (n, axes).

        command : ndarray, shape (n, axes)      [mm]
        begin   : ndarray of int, shape (s,)    samples at which a stretch begins; before the first the last one goes on
        rest    : ndarray of int, shape (s,)    samples of rest before each of them
        place   : ndarray of int, shape (n,)    where the print is; None: at place 0 throughout

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
        runs = self._runs(np.zeros(1, np.int64) if place is None or not place.any() else np.repeat(place, counts))
        out = np.empty(command.shape, order="F")
        shift = np.repeat(moved, length, axis=0)
        for axis, plant in enumerate(self._axes):
            u = np.repeat(command[:, axis] - shift[:, axis], counts)
            y = plant.follow(u, [(k, ba[axis], at) for k, ba, at in runs])
            np.add(y[where], shift[:, axis], out=out[:, axis])
        for axis, added in self._coupled:
            out[:, axis] += added.follow(np.repeat(command[:, 1 - axis] - shift[:, 1 - axis], counts))[where]
        self._last, self._moved = command[-1].copy(), moved[-1]
        return out

    def _runs(self, place: np.ndarray) -> list[tuple[int, Sequence[BA], int]]:
        """Places one after the other: which, its plants, and its first sample."""
        first = np.append(0, np.flatnonzero(np.diff(place)) + 1)
        return [(k, self._at(k), at) for k, at in zip(place[first].tolist(), first.tolist(), strict=True)]


class _Vibrating:
    """One axis: the plant that holds now, its state, and what it has heard since it rested at `_base`."""

    def __init__(self) -> None:
        self._place: int | None = None
        self._base, self._state = 0.0, np.zeros(0)
        self._heard = np.zeros(1)  # the last samples

    def follow(self, u: np.ndarray, runs: list[tuple[int, BA, int]]) -> np.ndarray:
        """What the axis makes of u, shape (n,), where a plant holds from each sample named on."""
        heard = np.concatenate((self._heard, u)) if len(runs) > 1 or runs[0][0] != self._place else u
        before = len(heard) - len(u)
        y = np.empty(len(u))
        for (place, (b, a), first), end in zip(runs, [*(first for *_, first in runs[1:]), len(u)], strict=True):
            start = before + first
            if place != self._place:  # as if it had held, and rested, MEMORY samples ago
                start = max(0, start - MEMORY)
                self._place, self._base, self._state = place, heard[start], np.zeros(max(len(b), len(a)) - 1)
            out, self._state = _filtered(b, a, heard[start : before + end] - self._base, self._state)
            y[first:end] = out[len(out) - (end - first) :] + self._base
        self._heard = np.concatenate((self._heard, u[-MEMORY:]))[-MEMORY:]
        return y


class _Coupled:
    """What the command of one axis adds to the other: nothing as long as it stands."""

    def __init__(self, ba: BA):
        self._ba, self._state = ba, np.zeros(max(map(len, ba)) - 1)
        self._base: float | None = None  # where it stood

    def follow(self, u: np.ndarray) -> np.ndarray:
        """More of it, shape (n,)."""
        if self._base is None:
            self._base = float(u[0])
        y, self._state = _filtered(*self._ba, u - self._base, self._state)
        return y


def _filtered(b: np.ndarray, a: np.ndarray, u: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`lfilter` with its state; long finite responses by overlapping transforms."""
    if len(a) > 1 or len(b) < LONG:
        return lfilter(b, a, u, zi=state)
    y = oaconvolve(u, b / a[0])
    y[: len(state)] += state
    return y[: len(u)], y[len(u) :]
