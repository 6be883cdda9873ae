"""Planning a file part by part: what no later move can change, in pieces of bounded duration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.motion.lookahead import plan_block
from fbfcli.motion.moves import Moves
from fbfcli.motion.profile import Profile, profile
from fbfcli.printer import Limits

PART_S = 150.0  # of motion in one part: bounds the memory of all that follows
LONGEST_MOVE_S = 30.0  # a slower move is divided


@dataclass(frozen=True)
class Part:
    """Consecutive moves whose plan is final.

    moves   : Moves
    tag     : ndarray, shape (n,)   what the caller said of each move
    profile : Profile
    next    : Moves | None          the move after them (one), None at the end of the file
    """

    moves: Moves
    tag: np.ndarray
    profile: Profile
    next: Moves | None


class Planner:
    """The look-ahead of one file, fed with its moves."""

    def __init__(self, firmware: str):
        self._firmware = firmware
        self._pending: tuple[Moves, np.ndarray] | None = None
        self._previous: Moves | None = None
        self._w = 0.0

    def feed(self, moves: Moves, tag: np.ndarray, last: bool) -> Iterator[Part]:
        """Parts that are final with these moves; `last`: no more will come."""
        moves, tag = divided(moves, tag)
        if self._pending:
            moves, tag = joined(self._pending[0], moves), np.concatenate([self._pending[1], tag])
        self._pending = None
        if not len(moves):
            return
        plan, n = plan_block(moves, self._firmware, self._previous, self._w, last)
        timing = profile(plan)
        if n:
            self._previous, self._w = moves[n - 1 : n], float(plan.w_end[-1])
        if n < len(moves):
            self._pending = moves[n:], tag[n:]
        yield from in_parts(moves, tag, timing)


def in_parts(moves: Moves, tag: np.ndarray, timing: Profile) -> Iterator[Part]:
    """Moves, the first of which are planned, in pieces of PART_S."""
    n = len(timing)
    cuts = np.searchsorted(np.cumsum(timing.duration), np.arange(PART_S, timing.duration.sum(), PART_S)) + 1
    cuts = np.unique(np.concatenate([[0], np.minimum(cuts, n), [n]]))
    for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        yield Part(moves[a:b], tag[a:b], timing[a:b], moves[b : b + 1] if b < len(moves) else None)


def divided(moves: Moves, tag: np.ndarray) -> tuple[Moves, np.ndarray]:
    """Moves slower than LONGEST_MOVE_S cut into equal pieces: straight on, a planner does not see the cut."""
    if not len(moves):
        return moves, tag
    pieces = np.maximum(np.ceil(moves.distance / (moves.speed * LONGEST_MOVE_S)), 1.0).astype(np.int64)
    if pieces.max() == 1:
        return moves, tag
    index = np.repeat(np.arange(len(moves)), pieces)
    place = np.arange(len(index)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    delta = moves.delta[index] / pieces[index, None]
    start = moves.start[index] + place[:, None] * delta
    return Moves(
        start,
        delta,
        moves.speed[index],
        moves.stop[index] & (place == 0),
        moves.state[index],
        moves.line[index],
        moves.limits,
    ), tag[index]


def joined(a: Moves, b: Moves) -> Moves:
    """Two consecutive rows of moves; the later one's table of limits continues the earlier one's."""
    table = b.limits if len(b.limits) >= len(a.limits) else a.limits
    rows = {
        name: np.concatenate([getattr(a, name), getattr(b, name)])
        for name in ("start", "delta", "speed", "stop", "state", "line")
    }
    return replace(a, limits=table, **rows)


def no_part(limits: tuple[Limits, ...]) -> Part:
    """A part without moves, for the lines around motion."""
    none, flags, numbers = np.zeros((0, 4)), np.zeros(0, dtype=bool), np.zeros(0, dtype=np.int64)
    empty = np.zeros(0)
    return Part(Moves(none, none, empty, flags, numbers, numbers, limits), flags, Profile(*([empty] * 8)), None)
