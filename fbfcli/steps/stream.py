"""Steps of several motors, in pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class MotorSteps:
    """Steps of one motor.

    time    : ndarray of int64, shape (n,)   when each pulse begins, increasing [ns]
    forward : ndarray of bool, shape (n,)    its direction
    """

    time: np.ndarray
    forward: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    @property
    def moved(self) -> int:
        """Steps forward less steps backward."""
        return 2 * int(np.count_nonzero(self.forward)) - len(self.forward)


@dataclass(frozen=True)
class Steps:
    """Steps of all motors from `begin` on and before `end` [ns]; `motors` in the order of the stream's names."""

    begin: int
    end: int
    motors: tuple[MotorSteps, ...]


@dataclass(frozen=True)
class Motors:
    """What a stream says of its motors; names are single words."""

    names: tuple[str, ...]
    steps_per_mm: tuple[float, ...]


def no_steps() -> MotorSteps:
    """A motor that stands."""
    return MotorSteps(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool))


def joined(parts: Sequence[MotorSteps]) -> MotorSteps:
    """Pieces of one motor's steps, one after the other."""
    return MotorSteps(
        np.concatenate([part.time for part in parts] or [no_steps().time]),
        np.concatenate([part.forward for part in parts] or [no_steps().forward]),
    )


def merged(motors: Sequence[MotorSteps]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [ns], motor and direction of all steps in the order of time; at one time in the order of the motors."""
    time = np.concatenate([one.time for one in motors])
    motor = np.repeat(np.arange(len(motors), dtype=np.uint8), [len(one) for one in motors])
    order = np.argsort(time, kind="stable")
    return time[order], motor[order], np.concatenate([one.forward for one in motors])[order]


def parted(time: np.ndarray, motor: np.ndarray, forward: np.ndarray, count: int) -> tuple[MotorSteps, ...]:
    """The steps of each of `count` motors: `merged` undone."""
    return tuple(MotorSteps(time[motor == i], forward[motor == i]) for i in range(count))


@dataclass(frozen=True)
class Piece:
    """A piece of a stream: its steps, and the positions that they come from.

    tick     : ndarray of int64, shape (n,)    when each position is [periods]; across a gap the motors stand
    position : ndarray, shape (n, motors)      [mm]
    """

    steps: Steps
    tick: np.ndarray
    position: np.ndarray
