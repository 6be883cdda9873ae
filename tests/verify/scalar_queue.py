"""Marlin's block queue once more, event by event and with plain floats: what the array code has to agree with."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scalar_planners import trapezoid_time

from fbfcli.motion.junctions import corner_limits, standing_start
from fbfcli.motion.moves import Moves

END_W = 0.05**2


@dataclass
class Block:
    """A queued move: w is squared speed."""

    d: float
    accel: float
    cruise: float
    cap: float  # highest entry w
    entry: float
    fixed: bool  # the entry is what it is
    leave: float = 0.0


def marlin_times(
    moves: Moves, blocks: int, period: float, segment_s: float, waits_s: float = 0.1, end_w: float = END_W
):
    """When each move begins and how long it lasts [s], by events: a line comes, a block begins, a block ends."""
    n = len(moves)
    began, lasts = [math.nan] * n, [math.nan] * n
    queue: list[tuple[int, Block]] = []
    busy: tuple[int, Block] | None = None
    busy_end, now, came, j = 0.0, 0.0, 0.0, 0
    standing_since: float | None = None  # a block waits for others since then
    asked = moves
    while j < n or queue or busy:
        room = len(queue) + (busy is not None) < blocks - 1
        if j < n and bool(moves.stop[j]):
            room = not queue and busy is None
        line = max(came + period, now) if j < n and room else math.inf
        if busy is not None:
            begin = math.inf
        elif queue and (standing_since is None or len(queue) >= 3):
            begin = now
        elif queue:
            begin = max(standing_since + waits_s, now)
        else:
            begin = math.inf
        end = busy_end if busy is not None else math.inf
        now = min(line, begin, end)
        if end == now:
            busy = None
            continue
        if begin == now:
            i, block = queue.pop(0)
            standing_since = None
            block.leave = queue[0][1].entry if queue and not queue[0][1].fixed else min(end_w, block.cruise)
            if queue:
                queue[0][1].fixed = True
            top = min(0.5 * (block.entry + block.leave + 2 * block.accel * block.d), block.cruise)
            began[i] = now
            lasts[i] = trapezoid_time(block.d, block.accel, min(block.entry, top), top, min(block.leave, top))
            busy, busy_end = (i, block), now + lasts[i]
            continue
        came = now
        if not queue and busy is None:
            standing_since = now
        asked = stretched(asked, j, len(queue), blocks, segment_s)
        queue.append((j, block_of(asked, j, not queue)))
        replan([block for _, block in queue], end_w)
        j += 1
    return began, lasts


def stretched(moves: Moves, j: int, waiting: int, blocks: int, segment_s: float) -> Moves:
    """M205 B: a short segment asks for more time while two to half a queue of others wait."""
    d = float(moves.distance[j])
    lasts = round(1e6 * d / float(moves.speed[j]))
    if 2 <= waiting <= blocks // 2 - 1 and lasts < 1e6 * segment_s:
        speed = moves.speed.copy()
        speed[j] = 1e6 * d / (lasts + math.floor(2 * (1e6 * segment_s - lasts) / waiting))
        return replace(moves, speed=speed)
    return moves


def block_of(moves: Moves, j: int, alone: bool) -> Block:
    one = moves[j : j + 1]
    corners = corner_limits(one, "marlin", moves[j - 1 : j] if j else None)
    fresh = alone or bool(moves.stop[j])
    accel, d = float(corners.accel[0]), float(one.distance[0])
    slower = min(float(each) for each in corner_limits(moves[max(j - 1, 0) : j + 1], "marlin").cruise)
    standing = min(float(standing_start(one, "marlin")[0]), END_W + 2 * accel * d)
    w = standing if fresh else min(float(corners.entry[0]), slower)
    return Block(
        float(one.distance[0]), float(corners.accel[0]), float(corners.cruise[0]), w, 0.0 if not fresh else w, fresh
    )


def replan(queue: list[Block], end_w: float) -> None:
    """Backwards from the end of the last, then forwards; what is fixed stays."""
    w = end_w
    for block in reversed(queue):
        w = min(block.cap, w + 2 * block.accel * block.d)
        if not block.fixed:
            block.entry = w
    for before, block in pairwise(queue):
        if not block.fixed:
            block.entry = min(block.entry, before.entry + 2 * before.accel * before.d)


def steps_kept(ends: np.ndarray, start: np.ndarray, rates: np.ndarray, least: int = 6) -> list[bool]:
    """Which moves have at least so many steps from where the last such one ended."""
    at, kept = np.rint(start * rates), []
    for end in np.rint(ends * rates):
        kept.append(bool(np.abs(end - at).max() >= least))
        at = end if kept[-1] else at
    return kept
