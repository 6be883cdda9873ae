"""Pulses against what a driver's inputs can take: gaps between steps, and the direction's set-up time."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from fbfcli.printer import Driver
from fbfcli.steps.stream import MotorSteps
from fbfcli.units import NS_PER_S

ROUNDING_NS = 1  # of a gap between two rounded times
NS_PER_DAY = 86_400 * int(NS_PER_S)  # longer than any gap that matters


@dataclass(frozen=True)
class TooFast:
    """A gap that the driver does not take: when it ends [ns], and the rate it would be [steps/s]."""

    time: int
    rate: float


class Inputs:
    """The step and direction inputs of one driver.

    shortest : between two steps in one direction so far [ns]; None before the second step
    """

    def __init__(self, driver: Driver):
        self._least = floor(NS_PER_S / driver.max_step_rate) - ROUNDING_NS
        self._turn = ceil((driver.step_pulse + driver.direction_setup) * NS_PER_S)
        self._last: MotorSteps | None = None
        self.shortest: int | None = None

    @property
    def peak_rate(self) -> float:
        """Highest rate so far [steps/s]."""
        return NS_PER_S / self.shortest if self.shortest else 0.0

    def taking(self, steps: MotorSteps) -> MotorSteps | TooFast:
        """The same steps, those after a turn that came too soon later by a few ns; or the first gap that is too short.

        After a turn the pulse must be over, and the direction stand for its set-up time, before the next step.
        """
        if not len(steps):
            return steps
        time, forward = steps.time, steps.forward
        before = self._last or MotorSteps(time[:1] - NS_PER_DAY, forward[:1])
        gap = np.diff(time, prepend=before.time)
        turned = np.flatnonzero(np.diff(forward, prepend=before.forward))
        if len(turned) and gap[turned].min() < self._turn:
            time = _waiting(time, turned, self._turn, before)
            gap = np.diff(time, prepend=before.time)
        gap[turned] = np.maximum(gap[turned], NS_PER_DAY)
        shortest = int(gap.min())
        if shortest < self._least:
            first = int(np.flatnonzero(gap < self._least)[0])
            return TooFast(int(time[first]), NS_PER_S / max(int(gap[first]), 1))
        if shortest < NS_PER_DAY:
            self.shortest = min(shortest, self.shortest or shortest)
        self._last = MotorSteps(time[-1:], forward[-1:])
        return MotorSteps(time, forward)


def _waiting(time: np.ndarray, turned: np.ndarray, turn: int, before: MotorSteps) -> np.ndarray:
    """Times with at least `turn` before every turned step: t'_i = max(t_i, t'_(i-1) + turn), a running maximum."""
    least = np.zeros(len(time), dtype=np.int64)
    least[turned] = turn
    least = np.cumsum(least)
    return np.maximum.accumulate(np.maximum(time - least, before.time)) + least
