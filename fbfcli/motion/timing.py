"""Speeds that make a planner spend the wanted time on each segment.

A planner loses dv^2 / (2 a v) at every change of speed, and a rounded F and rounded coordinates add to it (FORMATS
"Time must be fed back"). The planner model is asked what it would do, and what it is late is taken off the time asked for.
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
HELD_UP_S = 1e-6  # a segment this late after its loss was corrected cannot be faster
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

    A segment that limits hold up (a wipe at the extruder's top speed) makes the ones after it a little faster.
    """
    distance = moves.distance
    least = LEAST_SHARE * wanted
    ask = np.maximum(wanted - made_good(np.zeros(len(wanted)), CATCH_UP * wanted, late), least)
    for attempt in range(ATTEMPTS):
        asked = replace(moves, speed=quantise(distance / ask))
        done = executed(asked, firmware, goes_in, goes_on)
        error = done.duration - wanted
        if attempt == ATTEMPTS - 1 or np.abs(late + np.cumsum(error)).max() < ON_TIME_S:
            break
        if attempt == 0:
            ask = np.maximum(ask - (done.duration - ask), least)
        else:
            capacity = np.where(error > HELD_UP_S, 0.0, CATCH_UP * wanted)
            ask = np.maximum(ask - made_good(error, capacity, late), least)
    return asked, done


def made_good(delay: np.ndarray, capacity: np.ndarray, late: float) -> np.ndarray:
    """Time that each segment gains on its own to end the lateness so far, shape (n,) [s].

    delay    : ndarray, shape (n,)   lateness that arises in each segment, negative where it is early
    capacity : ndarray, shape (n,)   the most each can gain
    late     : lateness before the first; negative: early

    late_i = max(0, late_{i-1} + delay_i - capacity_i): a queue's waiting time (Lindley), hence a running minimum.
    """
    S = np.cumsum(delay - capacity) + max(late, 0.0)
    left = S - np.minimum(np.minimum.accumulate(S), 0.0)
    gain = np.diff(-left, prepend=-max(late, 0.0)) + delay
    gain[0] += min(late, 0.0)
    return gain
