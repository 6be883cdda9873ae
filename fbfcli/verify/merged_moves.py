"""Marlin's moves of a few steps: they are not queued, and the next one starts where the last queued one ended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fbfcli.motion.budget import MARLIN_STEPS
from fbfcli.motion.kinematics import Kinematics
from fbfcli.motion.moves import Moves

E_STEPS_PER_MM = 100.0  # of a direct extruder without gears, the fewest that are usual
SET_MM = 1e-6  # a move that starts further from where the one before ended: the position was set (homing)


class Merging:
    """The steps of one file's moves.

    motors         : of the toolhead's axes; None: they are the axes
    steps_per_mm   : of each motor
    e_steps_per_mm : of filament; None: the profile does not say, E_STEPS_PER_MM
    """

    def __init__(self, motors: Kinematics | None, steps_per_mm: tuple[float, ...], e_steps_per_mm: float | None):
        self._motors, self._rates = motors, np.array([*steps_per_mm, e_steps_per_mm or E_STEPS_PER_MM])
        self._end: np.ndarray | None = None  # of the last move, queued or not [mm]
        self._queued = np.zeros(4)  # where the last queued one ended [mm]
        self._stop = False  # there was a stop before a move that was not queued
        self.dropped = 0

    def merged(self, moves: Moves, tag: np.ndarray) -> tuple[Moves, np.ndarray]:
        """The moves that are queued, from where the one queued before ended, and their tags."""
        if not len(moves):
            return moves, tag
        ends = moves.start + moves.delta
        came_from = np.vstack([moves.start[:1] if self._end is None else self._end, ends[:-1]])
        anew = (np.abs(moves.start - came_from) > SET_MM).any(axis=1)
        anew[0] |= self._end is None
        first = moves.start[:1] if anew[0] else self._queued[None]
        steps = self._steps(np.vstack([first, ends]))
        anew_steps = self._steps(moves.start[anew])
        short = np.abs(np.diff(steps, axis=0)).max(axis=1) < MARLIN_STEPS
        self._end = ends[-1].copy()
        if not (short | anew).any() and not self._stop:
            self._queued = ends[-1].copy()
            if (first == moves.start[:1]).all():
                return moves, tag
        keep, origin = _kept(steps.tolist(), anew.tolist(), anew_steps.tolist())
        start = np.where((origin >= 0)[:, None], ends[origin], first)
        start[anew] = moves.start[anew]
        after_drop = np.flatnonzero(~keep)  # a stop before a dropped move is one before the next that is queued
        stop = np.append(moves.stop, False)
        carried = self._stop
        for i in after_drop.tolist():
            stop[i + 1] |= stop[i]
        if carried and len(keep):
            stop[int(keep.argmax()) if keep.any() else -1] = True
        self._stop = bool(stop[-1])
        if keep.any():
            self._queued = ends[np.flatnonzero(keep)[-1]].copy()
        elif anew.any():
            self._queued = moves.start[np.flatnonzero(anew)[-1]].copy()
        self.dropped += len(after_drop)
        return replace(moves, start=start, delta=ends - start, stop=stop[:-1])[keep], tag[keep]

    def _steps(self, x: np.ndarray) -> np.ndarray:
        """Nearest steps of positions (n, 4), int, shape (n, 4)."""
        q = x if self._motors is None else np.column_stack([self._motors.motors(x[:, :3]), x[:, 3]])
        return np.rint(q * self._rates).astype(np.int64)


def _kept(steps: list[list[int]], anew: list[bool], anew_steps: list[list[int]]) -> tuple[np.ndarray, np.ndarray]:
    """Which moves are queued, bool, and after which the position of each still is, int, -1: none, shapes (n,).

    steps : n + 1 positions, that before the first move first
    anew  : the position was set before a move, to the next of `anew_steps`
    """
    keep, origin = [], []
    at, last, given = steps[0], -1, iter(anew_steps)
    for i, (end, is_anew) in enumerate(zip(steps[1:], anew, strict=True)):
        if is_anew:
            at, last = next(given), -1
        origin.append(last)
        far = max(abs(a - b) for a, b in zip(end, at, strict=True)) >= MARLIN_STEPS
        keep.append(far)
        if far:
            at, last = end, i
    return np.array(keep), np.array(origin)
