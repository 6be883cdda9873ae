"""Step times as parabolas of the step number, each within a tolerance: what the compact format stores.

t_j = begin + j interval + (j (j - 1) / 2) add, j = 0 ... count - 1, in whole ns: the interval from one step to the next
grows by `add`. Klipper's step compression has the same law (klippy/chelper/stepcompress.c).

A run of steps in one direction is cut into blocks of 64 and a rest in powers of two. A block is fitted by least
squares; one that misses the tolerance is halved; two steps always fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.steps.stream import MotorSteps

BLOCKS_AT_ONCE = 2048  # keeps their arrays in the cache
LARGEST = 64  # a rounded `add` is off by up to 1/2 ns, and 64^2 / 16 of it remain in the middle


@dataclass(frozen=True)
class Parabolas:
    """n parabolas of one motor, in the order of time.

    begin, interval, add : ndarray of int64, shape (n,)   [ns]
    count                : ndarray of int64, shape (n,)   steps of each
    forward              : ndarray of bool, shape (n,)
    """

    begin: np.ndarray
    interval: np.ndarray
    add: np.ndarray
    count: np.ndarray
    forward: np.ndarray

    def __len__(self) -> int:
        return len(self.count)

    def last(self) -> np.ndarray:
        """Time of the last step of each, shape (n,)."""
        j = self.count - 1
        return self.begin + j * self.interval + j * (j - 1) // 2 * self.add

    def steps(self) -> MotorSteps:
        """The steps they stand for."""
        of = np.repeat(np.arange(len(self)), self.count)
        j = np.arange(len(of)) - (np.cumsum(self.count) - self.count)[of]
        time = self.begin[of] + j * self.interval[of] + j * (j - 1) // 2 * self.add[of]
        return MotorSteps(time, self.forward[of])


def fitted(steps: MotorSteps, tolerance: int) -> Parabolas:
    """Parabolas from which no step's time differs by more than `tolerance` [ns]."""
    first, size = _blocks(steps.forward)
    found: list[np.ndarray] = []
    half = np.zeros(0, dtype=np.int64)  # first steps of blocks that were halved
    for count in (2**k for k in range(LARGEST.bit_length() - 1, -1, -1)):
        begin = np.concatenate([first[size == count], half])
        half = half[:0]
        for part in np.split(begin, range(BLOCKS_AT_ONCE, len(begin), BLOCKS_AT_ONCE)):
            law, good = _fit(steps.time, part, count, tolerance)
            found.append(np.column_stack([part, law, np.full(len(part), count)])[good])
            missed = part[~good]
            half = np.concatenate([half, missed, missed + count // 2])
    table = np.concatenate(found)
    table = table[np.argsort(table[:, 0])]
    begin, interval, add, count = table[:, 1:].T.copy()
    return Parabolas(begin, interval, add, count, steps.forward[table[:, 0]])


def _blocks(forward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First step and size of blocks of one direction, each a power of two, none larger than LARGEST."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(forward)) + 1])[: len(forward)]
    length = np.diff(starts, append=len(forward))
    first, size = [], []
    whole = length // LARGEST
    number = np.arange(whole.sum()) - np.repeat(np.cumsum(whole) - whole, whole)
    first.append(np.repeat(starts, whole) + LARGEST * number)
    size.append(np.full(len(number), LARGEST))
    at = starts + LARGEST * whole
    for count in (2**k for k in range(LARGEST.bit_length() - 2, -1, -1)):
        here = (length & count) > 0
        first.append(at[here])
        size.append(np.full(len(first[-1]), count))
        at = at + np.where(here, count, 0)
    return np.concatenate(first), np.concatenate(size)


def _fit(time: np.ndarray, begin: np.ndarray, count: int, tolerance: int) -> tuple[np.ndarray, np.ndarray]:
    """begin, interval and add of blocks of `count` steps, shape (n, 3), and whether they keep the tolerance."""
    j = np.arange(count)
    q = j * (j - 1) // 2
    t = time[begin[:, None] + j] - time[begin][:, None]
    law = np.zeros((len(begin), 3), dtype=np.int64)
    if count <= 2:
        law[:, 1] = t[:, -1]
    else:
        basis = np.linalg.qr(np.column_stack([np.ones(count), j, q]))[0][:, 2]  # what a line leaves of q
        add = np.rint(t @ (basis / (basis @ q))).astype(np.int64)
        rest = t - add[:, None] * q
        slope = j - j.mean()
        law[:, 1] = np.rint(rest @ (slope / (slope @ j)))
        rest -= law[:, 1:2] * j
        law[:, 0] = np.rint(0.5 * (rest.max(axis=1) + rest.min(axis=1)))
        law[:, 2] = add
        rest -= law[:, :1]
        good = np.abs(rest).max(axis=1) <= tolerance
        law[:, 0] += time[begin]
        return law, good
    law[:, 0] = time[begin]
    return law, np.ones(len(begin), dtype=bool)
