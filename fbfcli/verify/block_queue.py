"""The queue of a planner: which blocks it knows when it settles how fast one may end, and when each begins.

Everything is causal: what is known to a block depends on when it begins, hence on the blocks before it alone. So the
queue is gone through in pieces, each again and again until nothing changes any more; each time, one block more is right
at least, mostly all of them.

    T  when a block comes into the queue        w  squared speed        D  2 a d of a block        [s, mm^2/s^2]
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from fbfcli.motion.junctions import Corners, corner_limits, standing_start
from fbfcli.motion.lookahead import Plan, reach
from fbfcli.motion.moves import Moves
from fbfcli.motion.profile import Profile, profile

PIECE = 256  # blocks that are planned together
TIE_S = 1e-9  # times closer than this are the same
US = 1e6


@dataclass(frozen=True)
class Queue:
    """A planner's queue.

    blocks    : in its ring; one of them is always empty
    period    : between two lines [s]
    end_w     : of the last block [mm^2/s^2]
    segment_s : blocks that take less are stretched while the queue is less than half full [s]; 0: none
    ahead_s   : blocks are settled so long before they begin, at most half of them [s]; 0: when they begin
    first_waits_s, first_waits_for : a block that comes while the machine stands waits so long [s], or for so many more
    """

    blocks: int
    period: float
    end_w: float = 0.0
    segment_s: float = 0.0
    ahead_s: float = 0.0
    first_waits_s: float = 0.0
    first_waits_for: int = 0


@dataclass(frozen=True)
class _Past:
    """What the blocks that are done leave behind: the last ones, as many as the ring has.

    move       : Moves | None          the last (one)
    w_end      : its speed at the end
    start, end : ndarray, shape (k,)   when each was taken from the queue, and when it ended
    came       : float                 T of the last
    """

    move: Moves | None
    w_end: float
    start: np.ndarray
    end: np.ndarray
    came: float


@dataclass(frozen=True)
class _Guess:
    """What decides a plan, of n blocks.

    asked : ndarray, shape (n,)           speed that each asks for, stretched or not [mm/s]
    known : ndarray of int, shape (n,)    one past the last block that is known when each is settled
    fresh : ndarray of bool, shape (n,)   no other waited when it came: it begins as from rest
    idle  : ndarray of bool, shape (n,)   the machine stood when it came
    came  : ndarray, shape (n,)           T
    """

    asked: np.ndarray
    known: np.ndarray
    fresh: np.ndarray
    idle: np.ndarray
    came: np.ndarray

    def same(self, other: _Guess) -> bool:
        return (
            all(
                bool((getattr(self, name) == getattr(other, name)).all())
                for name in ("known", "fresh", "idle", "asked")
            )
            and float(np.abs(self.came - other.came).max()) < TIE_S
        )


class BlockQueue:
    """The blocks of one file, in time."""

    def __init__(self, firmware: str, queue: Queue):
        self._firmware, self._queue = firmware, queue
        long_ago = np.full(queue.blocks, -np.inf)
        self._past = _Past(None, 0.0, long_ago, long_ago, 0.0)

    def executed(self, moves: Moves, last: bool) -> tuple[Profile, np.ndarray]:
        """What is settled of blocks that follow those before: their profile, and the speeds they ask for, (k,) [mm/s].

        last : no more will come
        """
        done: list[Profile] = []
        asked = [np.zeros(0)]
        begin, margin = 0, 2 * self._queue.blocks
        while begin < len(moves):
            more = moves[begin : begin + PIECE + margin]
            count = len(more) if last and begin + len(more) == len(moves) else min(PIECE, len(more) - margin)
            if count <= 0:
                break
            timing, speed = self._piece(more, count)
            done.append(timing)
            asked.append(speed)
            begin += count
        return _in_a_row(done), np.concatenate(asked)

    def _piece(self, moves: Moves, count: int) -> tuple[Profile, np.ndarray]:
        """The first `count` of some blocks, planned."""
        n, past = len(moves), self._past
        fresh = moves.stop.copy()
        fresh[0] |= past.move is None
        known = np.minimum(np.arange(n) + self._queue.blocks - 2, n)
        guess = _Guess(moves.speed, known, fresh, fresh, np.full(n, past.came))
        distance, asked = moves.distance, None
        for _ in range(n + 2):
            if asked is None or (asked != guess.asked).any():
                asked = guess.asked
                limits = self._limits(replace(moves, speed=asked))
            plan = self._plan(*limits, distance, guess)
            timing = profile(plan)
            start, end = self._times(timing.duration, guess)
            better = self._seen(moves, start, end)
            if better.same(guess):
                break
            guess = better
        blocks = self._queue.blocks
        self._past = _Past(
            replace(moves, speed=guess.asked)[count - 1 : count],
            float(plan.w_end[count - 1]),
            np.concatenate([past.start, self._taken(start, guess.idle)[:count]])[-blocks:],
            np.concatenate([past.end, end[:count]])[-blocks:],
            float(guess.came[count - 1]),
        )
        return timing[:count], guess.asked[:count]

    def _limits(self, moves: Moves) -> tuple[Corners, np.ndarray]:
        """What the blocks allow, and the w that each begins with where the machine stands."""
        return corner_limits(moves, self._firmware, self._past.move), standing_start(moves, self._firmware)

    def _plan(self, corners: Corners, standing: np.ndarray, distance: np.ndarray, guess: _Guess) -> Plan:
        """Speeds of the blocks, if each knows what it is guessed to know."""
        D = 2.0 * corners.accel * distance
        leaves = self._leaving(corners, D, guess.known)
        fresh = guess.fresh
        enters = np.where(fresh, np.minimum(standing, self._queue.end_w + D), 0.0)  # it can end there alone
        if not fresh[0]:
            enters[0] = self._past.w_end
        again = fresh.copy()  # a block that begins anew has a corner of its own beside the one before it
        again[0] = False
        at = np.arange(len(D)) + np.cumsum(again)
        W, way = np.zeros(at[-1] + 2), np.full(at[-1] + 1, np.inf)
        W[at + 1], way[at] = leaves, D
        W[at[again]], W[0] = enters[again], enters[0]
        w = reach(W, way)
        w_in, w_out = w[at], w[at + 1]
        c = np.minimum(0.5 * (w_in + w_out + D), corners.cruise)
        return Plan(distance, corners.accel, np.minimum(w_in, c), c, np.minimum(w_out, c))

    def _leaving(self, corners: Corners, D: np.ndarray, known: np.ndarray) -> np.ndarray:
        """The most each block may end with, so that the last that is known then can end with `end_w`, shape (n,)."""
        n, index = len(D), np.arange(len(D))
        w = np.full(n, self._queue.end_w)
        for k in range(int((known - index).max()) - 1, 0, -1):  # backwards, the k-th block after each
            rows = np.flatnonzero(index + k < known)
            j = rows + k
            w[rows] = np.minimum(np.minimum(corners.entry[j], corners.cruise[j]), w[rows] + D[j])
        return np.asarray(np.minimum(w, corners.cruise))

    def _times(self, duration: np.ndarray, guess: _Guess) -> tuple[np.ndarray, np.ndarray]:
        """When each block begins and ends, if they come as guessed."""
        queue, n = self._queue, len(duration)
        ready = guess.came.copy()
        first = np.flatnonzero(guess.idle)
        wait = ready[first] + queue.first_waits_s
        if queue.first_waits_for:
            other = np.minimum(first + queue.first_waits_for, n - 1)
            anew = np.cumsum(guess.fresh)
            come = (first + queue.first_waits_for < n) & (anew[other] == anew[first])
            wait = np.where(come, np.minimum(wait, guess.came[other]), wait)
        ready[first] = wait + queue.ahead_s
        passed = np.cumsum(duration)
        before = max(float(self._past.end[-1]), 0.0)
        end = passed + np.maximum(np.maximum.accumulate(ready - (passed - duration)), before)
        return np.maximum(ready, np.append(before, end[:-1])), end

    def _seen(self, moves: Moves, start: np.ndarray, end: np.ndarray) -> _Guess:
        """What each block sees if blocks begin and end so."""
        n, queue, past = len(moves), self._queue, self._past
        many = queue.blocks
        ends = np.concatenate([past.end, end])
        index = np.arange(n)
        room = ends[index + 1]  # block j - (blocks - 1) is done: there is room in the ring
        room = np.where(moves.stop, np.maximum(room, ends[index + many - 1]), room)
        came = np.maximum.accumulate(np.maximum(room, past.came + queue.period) - queue.period * index)
        came = came + queue.period * index
        idle = ends[index + many - 1] < came + TIE_S
        taken = np.concatenate([past.start, self._taken(start, idle)])
        begun = np.searchsorted(taken, came + TIE_S, side="right") - many
        waiting = index - begun  # blocks that have not begun when it comes
        settled = start
        if queue.ahead_s > 0.0:
            settled = np.maximum(start - queue.ahead_s, ends[index + many - many // 2]) + 2 * TIE_S
        known = np.searchsorted(came, self._taken(settled, idle) - TIE_S)
        known = np.maximum(known, index + 1)
        return _Guess(self._stretched(moves, waiting), known, moves.stop | (waiting <= 0), idle, came)

    def _taken(self, time: np.ndarray, idle: np.ndarray) -> np.ndarray:
        """Times of blocks, those that waited for others just after the last of these has come."""
        return time + 2 * TIE_S * idle if self._queue.first_waits_for else time

    def _stretched(self, moves: Moves, waiting: np.ndarray) -> np.ndarray:
        """Speeds that the blocks ask for when so many wait as they come."""
        queue = self._queue
        if queue.segment_s <= 0.0:
            return moves.speed
        distance = moves.distance
        lasts = np.rint(US * distance / moves.speed)
        short = np.floor(2.0 * (US * queue.segment_s - lasts) / np.maximum(waiting, 1))
        draining = (waiting >= 2) & (waiting < queue.blocks // 2) & (lasts < US * queue.segment_s)
        return np.where(draining, US * distance / np.maximum(lasts + short, 1.0), moves.speed)


def _in_a_row(parts: list[Profile]) -> Profile:
    if not parts:
        return Profile(*([np.zeros(0)] * len(fields(Profile))))
    return Profile(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Profile)))
