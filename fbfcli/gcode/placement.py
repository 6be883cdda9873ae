"""Where each kept line goes between the segments that replace the motion around it: at its time.

A place is a sample of the batch's grid: k inside a stretch, k + 1/2 in the rest after sample k, -1/2 before the first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing, join
from fbfcli.motion.moves import E, Moves, moves_xy
from fbfcli.motion.stretches import Grid

TIMELY = (int(Kind.IN_ORDER), int(Kind.MODE))  # lines that act, and want a node at their time


@dataclass(frozen=True)
class Places:
    """Kept lines and where they go; k of them.

    lines     : Listing
    sample    : ndarray, shape (k,)           place, non-decreasing
    e_machine : ndarray, shape (k,)           the machine's E after the line [mm]
    passed    : ndarray, shape (k,)           time of moves outside stretches, and of dwells, before the line [s]
    moves     : ndarray of bool, shape (k,)   a motion line whose motion stays as it was written
    barrier   : ndarray of bool, shape (k,)   the file's own limits hold for it: it moves X or Y, or is a barrier
    """

    lines: Listing
    sample: np.ndarray
    e_machine: np.ndarray
    passed: np.ndarray
    moves: np.ndarray
    barrier: np.ndarray

    def __len__(self) -> int:
        return len(self.sample)

    def __getitem__(self, rows: slice | np.ndarray) -> Places:
        columns = (self.sample, self.e_machine, self.passed, self.moves, self.barrier)
        return Places(self.lines[rows], *(column[rows] for column in columns))


def place(
    lines: Listing, moves: Moves, inside: np.ndarray, grid: Grid, outside_time: np.ndarray, e_before: float
) -> Places:
    """Places on the grid of the lines that belong to a part of the motion.

    inside       : ndarray of bool, shape (n,)   moves that are compensated
    outside_time : ndarray, shape (n,)           time each move takes outside stretches [s], 0 inside
    e_before     : the machine's E before the first move [mm]

    Motion lines whose moves are compensated are left out: segments stand for them. So are motion lines without motion
    next to one (their F is put back where it is next needed).
    """
    following = np.searchsorted(moves.line, lines.number, side="right")  # first move of a later line
    own = np.searchsorted(moves.line, lines.number, side="left")
    has_move = following > own
    motion = lines.kind == int(Kind.MOTION)
    replaced = motion & has_move & np.append(inside, False)[own]
    sample = _samples(following, moves, inside, grid)
    idle = motion & ~has_move & (sample == np.floor(sample))
    keep = ~(replaced | idle)
    e_after = np.append(moves.start[:, E] + moves.delta[:, E], e_before)  # [-1]: before the first move
    spent = np.concatenate([[0.0], np.cumsum(outside_time)])[own] + np.cumsum(lines.wait) - lines.wait
    flat = np.concatenate([[0], np.cumsum(moves_xy(moves))])
    barrier = (lines.kind == int(Kind.BARRIER)) | (flat[following] > flat[own])
    all_lines = Places(lines, sample, e_after[following - 1], spent, motion & has_move, barrier)
    return all_lines[keep]


def after(earlier: Places | None, later: Places) -> Places:
    """Places one after the other."""
    if earlier is None:
        return later
    return Places(
        join([earlier.lines, later.lines]),
        np.concatenate([earlier.sample, later.sample]),
        np.concatenate([earlier.e_machine, later.e_machine]),
        np.concatenate([earlier.passed, later.passed]),
        np.concatenate([earlier.moves, later.moves]),
        np.concatenate([earlier.barrier, later.barrier]),
    )


def _samples(following: np.ndarray, moves: Moves, inside: np.ndarray, grid: Grid) -> np.ndarray:
    """Place before the move `following` (len(moves): after the last), shape of `following`."""
    begins = np.zeros(len(moves) + 1)
    stretch_after = np.searchsorted(
        grid.move[grid.first[:-1]], np.arange(len(moves) + 1)
    )  # stretches begun before a move
    last_end = np.concatenate([[-1], grid.end])
    begins[:] = last_end[stretch_after] + 0.5
    inner = np.ones(len(grid.move), dtype=bool)
    inner[grid.first[:-1]] = False
    begins[grid.move[inner]] = np.rint(grid.t0[inner])
    if grid.continued and len(grid.move):
        begins[grid.move[0]] = np.rint(max(grid.t0[0], 0.0))
    if grid.open_last:
        begins[-1] = float(grid.count)
    return begins[following]


def forced(places: Places, first: int, last: int) -> np.ndarray:
    """Samples of lines that act at a time of their own, between two samples, exclusive."""
    lines = places.lines
    timely = np.isin(lines.kind, TIMELY) & (places.sample == np.floor(places.sample))
    at = places.sample[timely].astype(np.int64)
    return np.unique(at[(at > first) & (at < last)])


def segment_of(sample: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Segment (counted by nodes) before which a line of each place is written, non-decreasing."""
    after = np.searchsorted(nodes, sample, side="right")
    before = np.maximum(after - 1, 0)
    nearer = np.where(sample - nodes[before] <= nodes[np.minimum(after, len(nodes) - 1)] - sample, before, after)
    at = np.where(sample == np.floor(sample), nearer, after)
    return np.maximum.accumulate(np.minimum(at, len(nodes) - 1)) if len(at) else at
