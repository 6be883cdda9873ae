"""Stretches: motion of X and Y between two rests, laid on one sampling grid.

A stretch is what a compensator works on. Moves of Z or E alone (lifts, retractions) are no part of one: their limits
cannot be raised safely, so they stay as they were written, with X and Y at rest. The same holds for moves whose Z or E
part would make the planner slow a compensated segment down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.motion.moves import EPS_MM, E, Moves, Z
from fbfcli.motion.profile import Profile

Z_MARGIN = 4.0  # a segment's own acceleration limit must exceed the plan's this many times for a command to be followed
KINK_MM_S = 0.2  # a jump in the speed of E or Z that needs a node of its own
EPS_SAMPLE = 1e-6  # samples: rounding of times that meet


def compensable(moves: Moves, known: np.ndarray, acceleration: float | None) -> np.ndarray:
    """Which moves can be compensated, bool, shape (n,).

    known        : ndarray of bool, shape (n,)   X and Y are known where the move starts
    acceleration : that X and Y will be planned with [mm/s^2]; None: the limits in force

    A move with a Z part is, if the planner would still grant its segments Z_MARGIN times that acceleration. All chords
    of an arc fare alike.
    """
    dx, dy, dz = moves.delta[:, 0], moves.delta[:, 1], np.abs(moves.delta[:, Z])
    moving = known & (dx * dx + dy * dy > EPS_MM * EPS_MM)
    steep = np.flatnonzero(dz > EPS_MM)
    if len(steep):
        share = dz[steep] / moves.distance[steep]
        planned = acceleration if acceleration is not None else moves.limit("acceleration")[steep]
        a_z = moves.limit("axis_acceleration", Z, steep)
        v_z = moves.limit("axis_velocity", Z, steep)
        moving[steep] &= (a_z >= Z_MARGIN * planned * share) & (v_z >= 1.5 * moves.speed[steep] * share)
        chord = np.flatnonzero(np.diff(moves.line) == 0)
        if len(chord) and not moving[np.union1d(chord, chord + 1)].all():
            group = np.flatnonzero(np.diff(moves.line, prepend=-1) != 0)
            moving &= np.repeat(np.logical_and.reduceat(moving, group), np.diff(np.append(group, len(moving))))
    return moving


def with_rests(moves: Moves, inside: np.ndarray, inside_before: bool) -> Moves:
    """The moves with a stop wherever a stretch begins or ends."""
    change = np.diff(np.concatenate([[inside_before], inside]).astype(np.int8)) != 0
    return Moves(moves.start, moves.delta, moves.speed, moves.stop | change, moves.state, moves.line, moves.limits)


@dataclass(frozen=True)
class Grid:
    """Stretches of a batch on one sampling grid; s of them, m compensated moves.

    move   : ndarray of int, shape (m,)      index of each compensated move in the batch
    first  : ndarray of int, shape (s + 1,)  entries of `move` that belong to stretch j: first[j] to first[j + 1]
    begin  : ndarray of int, shape (s,)      first sample of each stretch
    end    : ndarray of int, shape (s,)      its last sample
    t0     : ndarray, shape (m,)             when each move starts [samples]
    count  : int                             samples in all
    phase  : float                           where the next move of the open last stretch starts, after sample `count`
    continued, open_last : bool              the first stretch began, the last one goes on in another batch
    """

    move: np.ndarray
    first: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    t0: np.ndarray
    count: int
    phase: float
    continued: bool
    open_last: bool

    @property
    def stretch(self) -> np.ndarray:
        """Stretch of each entry of `move`, shape (m,)."""
        return np.repeat(np.arange(len(self.begin)), np.diff(self.first))


@dataclass(frozen=True)
class Rests:
    """How a stretch meets the rests around it [samples]: held before, held after, shortest stretch there may be."""

    lead: int
    tail: int
    shortest: int


def stretch_starts(moves: Moves, inside: np.ndarray) -> np.ndarray:
    """Indices of the moves that begin a stretch; move 0 counts as one if it is inside."""
    new = inside.copy()
    new[1:] &= moves.stop[1:] | ~inside[:-1]
    return np.flatnonzero(new)


def lay(
    moves: Moves,
    inside: np.ndarray,
    duration: np.ndarray,
    dt: float,
    rests: Rests,
    phase: float | None,
    open_last: bool,
) -> Grid:
    """Put the stretches of a batch on a grid of period dt, one after the other.

    inside    : ndarray of bool, shape (n,)   moves that are compensated
    duration  : ndarray, shape (n,)           how long each move lasts [s]
    phase     : where the first stretch goes on, if it is one of the batch before [samples]; None: it begins
    open_last : the last stretch continues in the next batch
    """
    move = np.flatnonzero(inside)
    first = np.searchsorted(move, stretch_starts(moves, inside))
    lasts = duration[move] / dt
    elapsed = np.concatenate([[0.0], np.cumsum(lasts)])
    total = np.add.reduceat(lasts, first) if len(first) else np.zeros(0)
    offset = np.full(len(first), float(rests.lead))
    length = np.maximum(np.ceil(offset + total - EPS_SAMPLE) + rests.tail, rests.shortest)
    if phase is not None and len(first):
        offset[0] = phase
        length[0] = np.ceil(phase + total[0] - EPS_SAMPLE) + rests.tail
    next_phase = 0.0
    if open_last and len(first):
        length[-1] = np.floor(offset[-1] + total[-1] + EPS_SAMPLE)
        next_phase = offset[-1] + total[-1] - length[-1] - 1.0
    size = length.astype(np.int64) + 1
    begin = np.cumsum(size) - size
    t0 = elapsed[:-1] + np.repeat(begin + offset - elapsed[first], np.diff(np.append(first, len(move))))
    return Grid(
        move,
        np.append(first, len(move)),
        begin,
        begin + size - 1,
        t0,
        int(size.sum()),
        next_phase,
        phase is not None,
        open_last,
    )


def scaled(profile: Profile, slow: np.ndarray) -> Profile:
    """The same motion in `slow` (n,) times the time: v / slow, a / slow^2."""
    return Profile(
        v_start=profile.v_start / slow,
        v_cruise=profile.v_cruise / slow,
        v_end=profile.v_end / slow,
        accel=profile.accel / (slow * slow),
        t_accel=profile.t_accel * slow,
        t_cruise=profile.t_cruise * slow,
        t_decel=profile.t_decel * slow,
        duration=profile.duration * slow,
    )


def kinks(moves: Moves, profile: Profile, grid: Grid) -> np.ndarray:
    """Samples at which the speed of E or Z jumps inside a stretch: the written segments need a node there."""
    d = moves.distance[grid.move]
    inner = np.ones(len(grid.move), dtype=bool)
    inner[grid.first[:-1]] = False
    speed = profile.v_start[grid.move]
    jump = np.zeros(len(grid.move))
    for axis in (E, Z):
        share = moves.delta[grid.move, axis] / d
        jump[1:] = np.maximum(jump[1:], np.abs(np.diff(share)))
    where = np.flatnonzero(inner & (jump * speed > KINK_MM_S))
    return np.rint(grid.t0[where]).astype(np.int64)
