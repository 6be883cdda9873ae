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

PASSES = 3
LEAST_SHARE = 0.2  # of the wanted time: a segment that cannot be fast enough is not asked for infinite speed


def executed(moves: Moves, firmware: str, goes_in: bool = False, goes_on: bool = False) -> Profile:
    """What a planner makes of the moves under the limits in force.

    goes_in, goes_on : they are entered, and left, in motion; else from and to rest
    """
    w_first, w_last = (np.inf if moving else 0.0 for moving in (goes_in, goes_on))
    return profile(plan(corner_limits(moves, firmware), moves.distance, w_first, w_last))


def timed(moves: Moves, wanted: np.ndarray, firmware: str, quantise: Callable[[np.ndarray], np.ndarray],
          goes_in: bool = False, goes_on: bool = False) -> tuple[Moves, Profile]:
    """The moves with speeds under which the planner takes `wanted` (n,) seconds for each, and what it then does.

    quantise : the speed that a written F stands for [mm/s]; applied before the planner is asked
    """
    distance = moves.distance
    ask = wanted.copy()
    for i in range(PASSES):
        moves = replace(moves, speed=quantise(distance / ask))
        done = executed(moves, firmware, goes_in, goes_on)
        if i < PASSES - 1:
            ask = np.maximum(ask + (wanted - done.duration), LEAST_SHARE * wanted)
    return moves, done
