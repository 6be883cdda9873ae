"""Input shaping inside the firmware: what it plans for X and Y, repeated by a few impulses and centred in time.

A, t : weights (sum 1) and times of the impulses, their mean taken out      u(k) = sum_i A_i x(k - t_i)
As Klipper does it (klippy/chelper/kin_shaper.c): on the continuous plan, so that motion begins before what was planned
and ends after it, each by about half the shaper's length; Z, E and time stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Plan:
    """n samples of a plan; across a gap in `tick` the machine stands.

    tick : ndarray of int64, shape (n,)   when [periods], increasing
    x    : ndarray, shape (n, 4)          X Y Z E [mm]
    was  : ndarray, shape (n, 2)          what X and Y were set by, without a move, up to here [mm]
    line : ndarray of int, shape (n,)
    """

    tick: np.ndarray
    x: np.ndarray
    was: np.ndarray
    line: np.ndarray

    def __len__(self) -> int:
        return len(self.tick)

    def __getitem__(self, rows: slice | np.ndarray) -> Plan:
        return Plan(self.tick[rows], self.x[rows], self.was[rows], self.line[rows])

    def then(self, more: Plan) -> Plan:
        """The samples one after the other."""
        return Plan(
            np.concatenate([self.tick, more.tick]),
            np.concatenate([self.x, more.x]),
            np.concatenate([self.was, more.was]),
            np.concatenate([self.line, more.line]),
        )


NO_PLAN = Plan(np.zeros(0, dtype=np.int64), np.zeros((0, 4)), np.zeros((0, 2)), np.zeros(0, dtype=np.int64))


class InputShaping:
    """The shapers of X and Y, fed with a plan piece by piece.

    impulses : (A, T) of each axis, shapes (n,), (n,) [s]
    dt       : period [s]
    delay    : periods by which the print comes later: the impulses before the plan must have been there
    """

    def __init__(self, impulses: Sequence[tuple[np.ndarray, np.ndarray]], dt: float):
        self._pulses = [(A, (T - A @ T) / dt) for A, T in impulses]
        self.delay = max(int(np.ceil(-t.min())) for _, t in self._pulses)  # periods that motion begins before the plan
        self._late = max(int(np.ceil(t.max())) for _, t in self._pulses)  # and after it
        self._heard: Plan | None = None  # samples that are still needed
        self._given = 0  # of them are given out

    def push(self, plan: Plan, last: bool) -> tuple[Plan, np.ndarray]:
        """More of a plan; what is final with it, rests in which X and Y still move included, and u, shape (n, 2) [mm].

        last : no more will come. Before that there must be a sample at least. Times are `delay` later than planned.
        """
        heard = self._with_rests(plan, last)
        end = int(heard.tick[-1]) - (0 if last else self.delay)
        ready = max(int(np.searchsorted(heard.tick, end, side="right")), self._given)
        given = heard[self._given : ready]
        delayed = Plan(given.tick + self.delay, given.x, given.was, given.line)
        moved = heard.x[:, :2] - heard.was
        u = given.was.copy()
        for axis, (A, t) in enumerate(self._pulses):
            for weight, shift in zip(A.tolist(), t.tolist(), strict=True):
                u[:, axis] += weight * np.interp(given.tick - shift, heard.tick, moved[:, axis])
        keep = max(int(np.searchsorted(heard.tick, end - self._late)) - 1, 0)
        self._heard, self._given = heard[keep:], ready - keep
        return delayed, u

    def _with_rests(self, plan: Plan, last: bool) -> Plan:
        """What was heard and the plan, with as much of each rest as the shapers need on either side."""
        first = plan[:1]
        before = self._heard
        if before is None:
            before = Plan(first.tick - self.delay - 1, first.x, first.was, first.line)
        joined = before[-1:].then(plan)
        gap = np.diff(joined.tick, append=joined.tick[-1] + 1 + (self._late if last else 0)) - 1
        rest = np.minimum(gap, self._late + self.delay)
        row = np.repeat(np.arange(len(joined)), rest + 1)
        after = np.arange(len(row)) - np.repeat(np.cumsum(rest + 1) - rest - 1, rest + 1)
        left_out = np.where(after > self._late, (gap - rest)[row], 0)
        filled = Plan(joined.tick[row] + after + left_out, joined.x[row], joined.was[row], joined.line[row])
        return before[:-1].then(filled)
