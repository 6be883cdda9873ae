"""Positions to step times, motor by motor.

y position [steps], p steps taken. A step is taken where y crosses the half step: forward at p + 1/2 + h/2, backward at
p - 1/2 - h/2. The band h (Driver.hysteresis) keeps a position that trembles around a half step from chattering; y and p
differ by 1/2 + h/2 at most. A crossing is a candidate; it is a step if it leads to another p than the one before.

Within half a period y = y_0 + s_0 tau + a tau^2 / 2 (see `curve`), one direction throughout; turned that way, level D
above y_0 is met at tau = 2 D / (s_0 + sqrt(s_0^2 + 2 a D)): the root without cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.steps.curve import middle, slopes
from fbfcli.steps.stream import MotorSteps, no_steps
from fbfcli.units import NS_PER_S


@dataclass(frozen=True)
class Halves:
    """p halves of periods in which at least one level is crossed, turned so that the position rises.

    turn   : ndarray, shape (p,)          1 or -1
    first  : ndarray of int64, shape (p,) the first level crossed is `first` + 1/2 + h/2
    count  : ndarray of int64, shape (p,) levels crossed
    below  : ndarray, shape (p,)          from the start to that level [steps]
    slope, bend : ndarray, shape (p,)     at the start [steps/period, steps/period^2]
    begin  : ndarray, shape (p,)          start [periods]
    """

    turn: np.ndarray
    first: np.ndarray
    count: np.ndarray
    below: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    begin: np.ndarray


def halves(k: np.ndarray, y: np.ndarray, s: np.ndarray, band: float) -> Halves:
    """The halves of the periods between samples.

    k : ndarray of int64, shape (n,)   when each sample is [periods]
    y, s : ndarray, shape (n,)         position and slope there
    """
    y_mid, s_mid = middle(y, s)
    ends = np.empty(2 * len(y) - 1)
    ends[0::2], ends[1::2] = y, y_mid
    slope = np.empty(len(ends))
    slope[0::2], slope[1::2] = s, s_mid
    turn = np.where(np.repeat(np.diff(y), 2) < 0.0, -1.0, 1.0)
    level = 0.5 + 0.5 * band
    first = np.floor(turn * ends[:-1] - level) + 1.0
    count = np.floor(turn * ends[1:] - level) - first + 1.0
    at = np.flatnonzero(count > 0.0)
    turn, first = turn[at], first[at]
    return Halves(
        turn=turn,
        first=first.astype(np.int64),
        count=count[at].astype(np.int64),
        below=first + level - turn * ends[at],
        slope=np.abs(slope[at]),
        bend=turn * 2.0 * (slope[at + 1] - slope[at]),
        begin=k[at >> 1] + 0.5 * (at & 1),
    )


def crossings(half: Halves) -> tuple[np.ndarray, np.ndarray]:
    """Time [periods] of each candidate and the steps it leads to, shape (m,) each."""
    before = np.cumsum(half.count) - half.count
    of = np.repeat(np.arange(len(half.count)), half.count)
    number = np.arange(len(of))
    D = number + np.take(half.below - before, of)
    slope = np.take(half.slope, of)
    root = np.take(2.0 * half.bend, of)
    root *= D
    root += slope * slope
    np.maximum(root, 0.0, out=root)  # rounding, where the curve turns at the end of the half
    np.sqrt(root, out=root)
    root += slope
    D *= 2.0
    D /= root
    np.minimum(D, 0.5, out=D)
    D += np.take(half.begin, of)
    taken = np.take(half.first - before + 1, of)
    taken += number
    taken *= np.take(half.turn.astype(np.int64), of)
    return D, taken


class Motor:
    """Steps of one motor, from its positions piece by piece.

    set : whole steps that it was set, not moved, since the beginning (homing)
    """

    def __init__(self, steps_per_mm: float, band: float, period: float):
        self._steps_per_mm, self._band, self._period_ns = steps_per_mm, band, period * NS_PER_S
        self._k = np.zeros(0, dtype=np.int64)
        self._y = np.zeros(0)  # samples that the next piece needs again, less what the motor was set
        self.set, self._taken = 0, 0

    @property
    def taken(self) -> int:
        """Where the motor stands, from position 0 [steps]."""
        return self._taken + self.set

    def push(self, k: np.ndarray, q: np.ndarray, jump: np.ndarray, last: bool) -> MotorSteps:
        """Steps that are final with more positions; those of the last period wait for the next ones.

        k    : ndarray of int64, shape (n,)  when each sample is [periods], increasing; across a gap the motor stands
        q    : ndarray, shape (n,)           position [mm]
        jump : ndarray of int                samples to which the motor was set, not moved
        last : no more will come
        """
        y = q * self._steps_per_mm
        if not len(self._y) and len(y):
            self._taken = int(np.rint(y[0]))
            self._k, self._y = k[0] - np.array([1, 0]), y[[0, 0]]
        y = np.concatenate([self._y, y - self.set])
        k = np.concatenate([self._k, k])
        for i in (jump + len(self._y)).tolist():
            whole = int(np.rint(y[i] - y[i - 1]))
            y[i:] -= whole
            self.set += whole
        self._k, self._y = k[-3:], y[-3:]
        if last and len(y):  # rests, and then comes to the nearest step, whatever the band left it at
            k, y = np.append(k, k[-1] + [1, 2, 3]), np.append(y, [y[-1], np.rint(y[-1]), np.rint(y[-1])])
        if len(y) < 4:
            return no_steps()
        time, taken = crossings(halves(k[1:-1], y[1:-1], slopes(y), self._band))
        if not len(time):
            return no_steps()
        change = np.diff(taken, prepend=self._taken)
        self._taken = int(taken[-1])
        if not change.all():
            here = change != 0
            time, change = time[here], change[here]
        time *= self._period_ns
        return MotorSteps(np.rint(time, out=time).astype(np.int64), change > 0)
