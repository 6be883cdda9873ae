"""Everything a file does on one clock: compensated stretches, moves left alone, dwells, and the lines between.

The clock counts periods of the trajectory. A chain is what lies outside stretches from one rest to the next; it is
sampled as the firmware plans it. Chains, like stretches, begin on a tick: the last period of a chain is filled up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing
from fbfcli.gcode.modal import code_of
from fbfcli.motion.planner import Part
from fbfcli.motion.sample import sample
from fbfcli.motion.stretches import Grid, Rests, lay
from fbfcli.pipeline.commander import Batch

NO_REST = Rests(0, 0, 0)
SET_MM = 1e-6  # a position that changes by more without a move was set: by homing, or by a macro
EVENTS = (int(Kind.IN_ORDER), int(Kind.BARRIER), int(Kind.RETRACT), int(Kind.PROGRESS))


@dataclass(frozen=True)
class Track:
    """Positions of the machine, n samples.

    tick  : ndarray of int64, shape (n,)   when [periods], increasing; across a gap the machine stands
    x     : ndarray, shape (n, 4)          X Y Z E [mm]
    jump  : ndarray of int                 samples to which X, Y, Z were set, not moved
    line  : ndarray of int, shape (n,)     line of the file that asked for it, counted from 0
    """

    tick: np.ndarray
    x: np.ndarray
    jump: np.ndarray
    line: np.ndarray

    def __len__(self) -> int:
        return len(self.tick)

    def __getitem__(self, rows: slice) -> Track:
        a, b, _ = rows.indices(len(self))
        jump = self.jump[(self.jump >= a) & (self.jump < b)] - a
        return Track(self.tick[rows], self.x[rows], jump, self.line[rows])


@dataclass(frozen=True)
class Event:
    """A line of the file that is not motion: when its time comes [s], its number, counted from 1, and its text."""

    time: float
    line: int
    text: str


@dataclass(frozen=True)
class _Spans:
    """Samples of a part from rest to rest; s spans in the order of time, n rows, m moves in them.

    x, line : ndarray, shape (n, 4), (n,)      rows of all spans
    move    : ndarray of int, shape (s,)       first move of each span
    begin   : ndarray of int, shape (s,)       its first row, where the machine stands before it
    length  : ndarray of int, shape (s,)       periods of it that are known, -1 where its first row is not
    again   : ndarray of bool, shape (s,)      goes on from an earlier part: its first row is new
    start   : ndarray, shape (moves + 1,)      rows after `begin` at which each move of the part starts
    of      : ndarray of int, shape (moves + 1,)  span of each move; of the end, where it lies in the last span, else -1
    """

    x: np.ndarray
    line: np.ndarray
    move: np.ndarray
    begin: np.ndarray
    length: np.ndarray
    again: np.ndarray
    start: np.ndarray
    of: np.ndarray


class Timeline:
    """The clock of one file, fed part by part."""

    def __init__(self, dt: float):
        self._dt = dt
        self._phase: float | None = None  # of a chain that goes on
        self._x: np.ndarray | None = None  # where the machine stands
        self._told = -1  # tick of the last sample
        self._tick = 0  # now: dwells after that sample included
        self.sets: list[int] = []  # lines after which the machine was somewhere else without a move

    @property
    def time(self) -> float:
        """Since the beginning [s]."""
        return self._tick * self._dt

    def part(
        self, part: Part, inside: np.ndarray, batch: Batch | None, lines: Listing
    ) -> tuple[Track, list[Event]]:
        """Positions of a part of the motion, and its other lines as events.

        inside : ndarray of bool, shape (n,)   moves that are compensated
        batch  : their commands; None where nothing is compensated
        """
        spans = self._spans(part, inside, batch)
        following = np.searchsorted(part.moves.line, lines.number, side="right")
        ticks = np.ceil(lines.wait / self._dt - 1e-6).astype(np.int64)
        waited = np.bincount(following, ticks, len(inside) + 1).astype(np.int64)  # before each move
        track, base = self._laid(spans, waited)
        start = np.full(len(inside) + 1, float(self._tick))
        within = spans.of >= 0
        start[within] = base[spans.of[within]] + spans.start[within]
        upto = np.cumsum(ticks)  # dwells of a rest that come with a line or after it
        left = np.concatenate([[0], upto])[np.searchsorted(following, following, side="right")] - upto + ticks
        return track, self._events(lines, (start[following] - left) * self._dt)

    def _spans(self, part: Part, inside: np.ndarray, batch: Batch | None) -> _Spans:
        """The chains of a part, and its stretches, in the order of time."""
        outside = ~inside
        goes_on = bool(len(inside) and outside[-1] and part.next is not None and not part.next.stop[0])
        chains = lay(part.moves, outside, part.profile.duration, self._dt, NO_REST, self._phase, goes_on)
        self._phase = chains.phase if goes_on else None
        grids, known, commands = [chains], [chains.count], []
        if chains.count:
            moves = part.moves[chains.move]
            timing, t0 = part.profile[chains.move], chains.t0 * self._dt
            commands.append(sample(moves.start, moves.delta, moves.distance, timing, t0, chains.count, self._dt)[0])
        if batch is not None and len(batch.grid.begin):
            grids.append(batch.grid)
            known.append(len(batch.command))
            commands.append(np.column_stack([batch.command, batch.desired[:, 2:]]))
        again = [np.arange(len(grid.begin)) < (grid is chains and grid.continued) for grid in grids]
        move = np.concatenate([grid.move[grid.first[:-1]] for grid in grids])
        order = np.argsort(move, kind="stable")
        place = np.argsort(order, kind="stable")  # of each span, counted chains first, in the order of time
        start, of = np.zeros(len(inside) + 1), np.full(len(inside) + 1, -1)
        passed = 0
        for grid in grids:
            start[grid.move] = grid.t0 - grid.begin[grid.stretch]
            start[grid.move[grid.first[int(grid.continued) : -1]]] = 0.0  # of the rest that a stretch begins with
            of[grid.move] = place[passed + grid.stretch]
            passed += len(grid.begin)
            if grid.open_last:
                start[-1], of[-1] = grid.count - grid.begin[-1] + grid.phase, len(move) - 1
        rows = np.concatenate([[0], np.cumsum(known)])[:-1]
        begin = np.concatenate([grid.begin + row for grid, row in zip(grids, rows, strict=True)])
        length = [np.minimum(grid.end, n - 1) - grid.begin for grid, n in zip(grids, known, strict=True)]
        return _Spans(
            x=np.concatenate([*commands, np.zeros((0, 4))]),
            line=np.concatenate([_lines(part, grid, n) for grid, n in zip(grids, known, strict=True)]),
            move=move[order],
            begin=begin[order],
            length=np.concatenate(length)[order],
            again=np.concatenate(again)[order],
            start=start,
            of=of,
        )

    def _laid(self, spans: _Spans, waited: np.ndarray) -> tuple[Track, np.ndarray]:
        """The rows of the spans on the clock, and the tick of the first row of each span."""
        n = len(spans.move)
        there = spans.length >= 0
        first, last = spans.x[spans.begin[there]], spans.x[spans.begin[there] + spans.length[there]]
        before = np.concatenate([first[:1] if self._x is None else self._x[None], last[:-1]])[: len(first)]
        jump = np.zeros(n, dtype=bool)
        jump[there] = (np.abs(first - before)[:, :3] > SET_MM).any(axis=1) & ~spans.again[there]
        total = np.concatenate([[0], np.cumsum(waited)])
        rest = np.diff(total[spans.move + 1], prepend=0) + jump  # a set takes a tick: the motor comes to a whole step
        lasts = np.maximum(spans.length, 0)
        base = self._tick + np.cumsum(rest) + np.cumsum(lasts + spans.again) - lasts
        told = np.concatenate([[self._told], (base + lasts)[:-1]])[:n]
        fresh = spans.again | (base > told)  # its first row stands for the rest before it
        count = np.where(there, spans.length + fresh, 0)
        row = np.arange(count.sum()) + np.repeat(spans.begin + ~fresh - (np.cumsum(count) - count), count)
        tick = row + np.repeat(base - spans.begin, count)
        at_first = np.cumsum(count) - count
        track = Track(tick, spans.x[row], at_first[jump], spans.line[row])
        self._tick = (int(base[-1] + lasts[-1]) if n else self._tick) + int(
            total[-1] - (total[spans.move[-1] + 1] if n else 0)
        )
        if len(track):
            self._x, self._told = track.x[-1], int(tick[-1])
            self.sets += (track.line[track.jump] + 1).tolist()
        return track, base

    def _events(self, lines: Listing, time: np.ndarray) -> list[Event]:
        """The lines that are commands without motion, with their times."""
        told = [
            Event(float(time[i]), int(lines.number[i]) + 1, code_of(lines.raw(i)))
            for i in np.flatnonzero(np.isin(lines.kind, EVENTS)).tolist()
        ]
        return [event for event in told if event.text]  # a slicer's time comment is no command


def _lines(part: Part, grid: Grid, count: int) -> np.ndarray:
    """Line of the file for each row of a grid, shape (count,)."""
    if not len(grid.move):
        return np.zeros(count, dtype=np.int64)
    entry = np.searchsorted(grid.t0, np.arange(count), side="right") - 1
    return part.moves.line[grid.move[np.maximum(entry, 0)]]
