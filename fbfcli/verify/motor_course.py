"""What a print asks of the motors: speed, acceleration and force at each sample.

The load hangs behind the belt: what the rotor feels is not mass times the acceleration it is commanded, which jumps at
every junction, but mass times the acceleration of the nozzle that the plant lets through, as the spring between them
pulls. Only the rotor's own inertia follows the command. In Z, which has no model, the nozzle moves as commanded. The
plant is driven by the command, not by the rotor: an identified model has the rotor's give in it already.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fbfcli.motion.kinematics import Kinematics, in_reach
from fbfcli.printer import Load
from fbfcli.units import GRAVITY
from fbfcli.verify.passage import Passage

STICK = 1.0  # mm/s: below, dry friction grows with speed instead of jumping
N_PER_KG_MM_S2 = 1e-3
Z = 2


@dataclass(frozen=True)
class Asked:
    """n samples of three motors.

    q, speed, acceleration : ndarray, shape (n, 3)   [mm, mm/s, mm/s^2]
    force : ndarray, shape (n, 3)                    that holds the load, along q [N]
    time  : ndarray, shape (n,)                      [s]
    line  : ndarray of int, shape (n,)               counted from 0
    """

    q: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    time: np.ndarray
    line: np.ndarray


class Asking:
    """Turns passages into what they ask of the motors; a sample is final once the next one is there.

    loads : of X, Y, Z; None where nothing is said
    """

    def __init__(self, kinematics: Kinematics, loads: Sequence[Load | None], dt: float):
        self._kinematics, self._dt = kinematics, dt
        known = [load or Load(0.0) for load in loads]
        self._mass = np.array([load.mass for load in known])
        self._friction = np.array([load.friction for load in known])
        self._viscous = np.array([load.viscous for load in known])
        self._last: tuple[np.ndarray, ...] | None = None  # rows of the last two samples

    def add(self, passage: Passage) -> Asked:
        """Samples that are final with more of the print, never empty. Raises LimitError beyond a delta's reach."""
        execution = passage.execution
        x = execution.motion[:, :3]
        begins = np.zeros(len(x), dtype=bool)
        begins[execution.begin] = True
        more = (x, np.column_stack([passage.nozzle, x[:, Z]]), begins, execution.time, execution.line)
        if self._last is None:
            begins[0] = True
            self._last = tuple(rows[:1] for rows in more)
        return self._asked(more)

    def finish(self) -> Asked | None:
        """The last sample: the print rests after it."""
        if self._last is None:
            return None
        x, nozzle, _, time, line = (rows[-1:] for rows in self._last)
        return self._asked((x, nozzle, np.ones(1, dtype=bool), time, line))

    def _asked(self, more: tuple[np.ndarray, ...]) -> Asked:
        """Of all samples that have one before and one after them."""
        assert self._last is not None
        rows = tuple(np.concatenate(both) for both in zip(self._last, more, strict=True))
        self._last = tuple(values[-2:] for values in rows)
        x, nozzle, begins, time, line = rows
        q = in_reach(self._kinematics, x, line)
        starts, ends = begins[1:-1, None], begins[2:, None]
        # the field rests before a stretch and after it; the nozzle swings on, as if nothing pulled
        speed, acceleration = self._moving(q, starts, ends, 0.0)
        v, a = self._moving(nozzle, starts, ends, 1.0)
        F = self._mass * a * N_PER_KG_MM_S2 + self._friction * np.clip(v / STICK, -1.0, 1.0) + self._viscous * v
        F[:, Z] += self._mass[Z] * GRAVITY * N_PER_KG_MM_S2
        return Asked(q[1:-1], speed, acceleration, self._kinematics.forces(x[1:-1], F), time[1:-1], line[1:-1])

    def _moving(
        self, x: np.ndarray, starts: np.ndarray, ends: np.ndarray, on: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Speed and acceleration of inner samples; at the ends of a stretch its last step is made `on` times again."""
        here = x[1:-1]
        before, after = x[:-2], x[2:]
        before, after = (
            np.where(starts, here - on * (after - here) * ~ends, before),
            np.where(ends, here + on * (here - before) * ~starts, after),
        )
        return (after - before) / (2.0 * self._dt), (after - 2.0 * here + before) / self._dt**2
