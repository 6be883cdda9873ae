"""Trapezoids in time: how long a planned move accelerates, cruises and decelerates.

v [mm/s], w = v^2, a acceleration [mm/s^2], d distance [mm], t time [s]. A phase between speeds v1 and v2 at constant
acceleration covers |w2 - w1| / 2a and lasts that distance over the mean speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.motion.lookahead import Plan


@dataclass(frozen=True)
class Profile:
    """Speeds and times of n moves, each in three phases.

    v_start, v_cruise, v_end           : ndarray, shape (n,)  speeds [mm/s], v_cruise the highest of the three
    accel                              : ndarray, shape (n,)  planned acceleration [mm/s^2]
    t_accel, t_cruise, t_decel         : ndarray, shape (n,)  phases [s], none negative
    duration                           : ndarray, shape (n,)  their sum [s]
    """

    v_start: np.ndarray
    v_cruise: np.ndarray
    v_end: np.ndarray
    accel: np.ndarray
    t_accel: np.ndarray
    t_cruise: np.ndarray
    t_decel: np.ndarray
    duration: np.ndarray

    def __len__(self) -> int:
        return len(self.duration)

    def __getitem__(self, part: slice | np.ndarray) -> Profile:
        return Profile(self.v_start[part], self.v_cruise[part], self.v_end[part], self.accel[part],
                       self.t_accel[part], self.t_cruise[part], self.t_decel[part], self.duration[part])


def profile(plan: Plan) -> Profile:
    """The phases of each planned move; the distance under them is `plan.d`.

    Where rounding leaves less distance than the two ramps need, both ramps shrink alike.
    """
    v_start, v_cruise, v_end = np.sqrt(plan.w_start), np.sqrt(plan.w_cruise), np.sqrt(plan.w_end)
    per_w = 0.5 / plan.accel
    up = (plan.w_cruise - plan.w_start) * per_w
    down = (plan.w_cruise - plan.w_end) * per_w
    flat = plan.d - up
    flat -= down
    short = np.flatnonzero(flat < 0.0)
    if len(short):
        shrink = plan.d[short] / (up[short] + down[short])
        up[short] *= shrink
        down[short] *= shrink
        flat[short] = 0.0
    t_accel = _ramp_time(up, v_start, v_cruise)
    t_decel = _ramp_time(down, v_end, v_cruise)
    t_cruise = np.divide(flat, v_cruise, out=np.zeros_like(flat), where=v_cruise > 0.0)
    return Profile(v_start, v_cruise, v_end, plan.accel, t_accel, t_cruise, t_decel, t_accel + t_cruise + t_decel)


def _ramp_time(distance: np.ndarray, v_low: np.ndarray, v_high: np.ndarray) -> np.ndarray:
    """Time for `distance` between two speeds, 0 where both are 0."""
    v_sum = v_low + v_high
    return np.divide(2.0 * distance, v_sum, out=np.zeros_like(v_sum), where=v_sum > 0.0)
