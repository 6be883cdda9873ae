"""Speeds that make a planner spend the wanted time on each segment.

A planner loses dv^2 / (2 a v) at every change of speed, and a rounded F and rounded coordinates add to it: without
feedback the clock drifts. The planner model is asked what it would do; what it is late is taken off the time asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fbfcli.motion.junctions import corner_limits
from fbfcli.motion.lookahead import plan
from fbfcli.motion.moves import Moves
from fbfcli.motion.profile import Profile, profile

ATTEMPTS = 5  # of asking the planner
ON_TIME_S = 1e-5  # lateness that is left to the next batch
HELD_UP = 1e-3  # of a segment's time: one this late after its loss was corrected cannot be faster
LEAST_SHARE = 0.6  # of the wanted time: where the planner cannot be faster, F must not run away
CATCH_UP = 0.05  # of a segment's time may make good what earlier ones were late


def executed(moves: Moves, firmware: str, goes_in: bool = False, goes_on: bool = False) -> Profile:
    """What a planner makes of the moves under the limits in force.

    goes_in, goes_on : they are entered, and left, at their own speed; else from and to rest
    """
    corners = corner_limits(moves, firmware)
    w_first, w_last = float(corners.cruise[0]) if goes_in else 0.0, float(corners.cruise[-1]) if goes_on else 0.0
    return profile(plan(corners, moves.distance, w_first, w_last))


def timed(
    moves: Moves,
    wanted: np.ndarray,
    late: float,
    firmware: str,
    quantise: Callable[[np.ndarray], np.ndarray],
    goes_in: bool = False,
    goes_on: bool = False,
) -> tuple[Moves, Profile]:
    """The moves with speeds under which the planner takes `wanted` (n,) seconds for each, and what it then does.

    late     : how late the first one starts [s]
    quantise : the speed that a written F stands for [mm/s]; applied before the planner is asked

    A segment that limits hold up (a wipe at the extruder's top speed) makes the ones after it a little faster, up to
    the next stop: there, time no longer matters.
    """
    distance = moves.distance
    least = LEAST_SHARE * wanted
    starts = np.flatnonzero(moves.stop)
    ask = np.maximum(wanted - made_good(np.zeros(len(wanted)), CATCH_UP * wanted, starts, late), least)
    for attempt in range(ATTEMPTS):
        asked = replace(moves, speed=quantise(distance / ask))
        done = executed(asked, firmware, goes_in, goes_on)
        error = done.duration - wanted
        if attempt == ATTEMPTS - 1 or np.abs(lateness(error, starts, late)).max() < ON_TIME_S:
            break
        if attempt == 0:
            ask = np.maximum(ask - (done.duration - ask), least)
        else:
            side = _side(lateness(error, starts, late), starts)
            capacity = np.where(side * error > HELD_UP * wanted, 0.0, CATCH_UP * wanted)
            ask = np.maximum(ask - side * made_good(side * error, capacity, starts, float(side[0]) * late), least)
    return asked, done


def lateness(error: np.ndarray, starts: np.ndarray, late: float) -> np.ndarray:
    """Sum of the errors since the last of `starts`, or since `late` before the first, shape (n,) [s]."""
    total = late + np.cumsum(error)
    before = np.concatenate([[0.0], total[starts - 1]]) if len(starts) else np.zeros(1)
    if len(starts) and starts[0] == 0:
        before[1] = late
    return total - np.repeat(before, np.diff(starts, prepend=0, append=len(error)))


def _side(late: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Between stops: 1 where the largest lateness is a delay, -1 where the firmware is ahead, shape (n,)."""
    first = np.union1d([0], starts)
    ahead = np.maximum.reduceat(late, first) < -np.minimum.reduceat(late, first)
    return np.repeat(np.where(ahead, -1.0, 1.0), np.diff(first, append=len(late)))


def made_good(delay: np.ndarray, capacity: np.ndarray, starts: np.ndarray, late: float) -> np.ndarray:
    """Time that each segment gains to end the lateness so far, shape (n,) [s]; negative where it is early by itself.

    delay    : ndarray, shape (n,)   lateness that arises in each segment, negative where it is early
    capacity : ndarray, shape (n,)   the most each can gain
    starts   : ndarray of int        segments that start anew, on time
    late     : lateness before the first

    late_i = max(0, late_{i-1} + delay_i - capacity_i): a queue's waiting time (Lindley), hence a running minimum; each
    start is put below all that was before it.
    """
    drop = np.zeros(len(delay))
    drop[starts] = 1.0 + abs(late) + np.abs(delay).sum() + capacity.sum()
    start_late = np.zeros(len(delay))
    if not len(starts) or starts[0] != 0:
        start_late[0] = max(late, 0.0)
    S = np.cumsum(delay - capacity - drop) + start_late[0]
    floor = S.copy()
    floor[starts] = np.minimum(floor[starts], S[starts] - (delay - capacity)[starts])
    floor[0] = min(floor[0], S[0] - (delay - capacity)[0] - start_late[0])
    left = S - np.minimum.accumulate(floor)
    before = np.concatenate([start_late[:1], left[:-1]])
    before[starts] = 0.0
    return before + delay - left
