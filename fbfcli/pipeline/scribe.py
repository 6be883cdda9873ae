"""From commands to text: nodes, words, speeds, and the lines of the file between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import LimitError
from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing
from fbfcli.gcode.placement import Places, after, forced, place, segment_of
from fbfcli.gcode.raised import raised
from fbfcli.gcode.runs import Raised, kept_text, raised_where, raising, restoring
from fbfcli.gcode.stamp import TimeLine, time_line
from fbfcli.gcode.words import SCALE
from fbfcli.gcode.write import Modes, Words, feed_of, power_on_modes, segment_lines, speed_of, words_of
from fbfcli.motion.moves import E, Moves
from fbfcli.motion.nodes import Budget, break_points, fit
from fbfcli.motion.planner import Part
from fbfcli.motion.profile import Profile
from fbfcli.motion.stretches import kinks
from fbfcli.motion.timing import timed
from fbfcli.pipeline.commander import Batch
from fbfcli.printer import Limits
from fbfcli.verify.tally import Stretches, Tally


@dataclass(frozen=True)
class Patch:
    """A time to be filled in: where in the output, what, and the print time before it [s]."""

    offset: int
    line: TimeLine
    elapsed: float


@dataclass(frozen=True)
class _Segments:
    """Segments between the nodes of a batch, gaps between stretches included; k of them.

    node     : ndarray of int, shape (k + 1,)   samples
    pinned   : ndarray of bool, shape (k + 1,)  nodes where stretches begin and end
    words    : Words
    modes    : Modes                            of each segment
    first    : ndarray of int, shape (s,)       segment that begins each stretch
    """

    node: np.ndarray
    pinned: np.ndarray
    words: Words
    modes: Modes
    first: np.ndarray


@dataclass
class _Run:
    """Limits as the firmware has them: raised or not, from what, and what the file has in force."""

    raised: bool
    base: Limits
    in_force: Limits
    feed: float = np.nan


class Scribe:
    """Writes one file, batch by batch."""

    def __init__(self, firmware: str, limits: Limits, budget: Budget, dt: float, tally: Tally, write: Callable[[bytes], None],
                 stamp: bytes, patch_times: bool):
        self._stamp, self._firmware, self._budget, self._dt, self._tally = stamp, firmware, budget, dt, tally
        self._write, self._patch_times = write, patch_times
        self._run = _Run(False, limits, limits)
        self._held: Places | None = None  # lines whose time has not come
        self._modes = power_on_modes()  # after the last line written
        self._e = 0.0  # of the machine, after the last move [mm]
        self._late = 0.0  # clock error, made good by the next segment [s]
        self._rest = 0.0  # since the last stretch [s]
        self.elapsed = 0.0  # print time [s]
        self.dwelt = 0.0  # of it in dwells [s]
        self.written = 0  # bytes
        self.patches: list[Patch] = []

    def batch(self, batch: Batch, part: Part, inside: np.ndarray, lines: Listing, table: tuple[Limits, ...]) -> None:
        """Write the commands of a batch, and the lines of its part whose time has come.

        table : limits that `lines.state` counts in
        """
        idle = np.where(inside, 0.0, part.profile.duration)
        places = place(lines, part.moves, inside, batch.grid, idle, self._e)
        places = after(self._held, places)
        n = len(batch.command)
        due = places.sample < (n - 0.25 if batch.grid.open_last else np.inf)
        starts = part.moves.line[batch.start]
        barrier = places.lines.number[due & (places.lines.kind == Kind.BARRIER)]
        run = raised_where(places.lines.number[due], barrier, starts, self._run.raised)
        bases = self._bases(run, places[due], starts, table)
        text, offsets, node, spent = b"", np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64), np.zeros(1)
        segments = None
        if n:
            segments = self._segments(batch, part, places[due])
            timed_moves, done, feed = self._timed(segments, batch, bases)
            self._count(segments, timed_moves, done, batch, idle)
            text, offsets = segment_lines(segments.words, segments.modes, feed)
            node, spent = segments.node, _spent(segments.words.real, done)
        self._emit(places[due], run, starts, bases, segments, text, offsets, node, spent, table)
        self._carry(places, due, part, idle, float(spent[-1]), lines, batch.dropped, table)
        self._run.raised = run.after

    def finish(self) -> None:
        """Put the limits back at the end of the file."""
        if self._run.raised:
            self._put(restoring(self._firmware, self._run.in_force, self._run.feed))
            self._run.raised = False

    def _segments(self, batch: Batch, part: Part, places: Places) -> _Segments:
        n = len(batch.command)
        ends = np.column_stack([batch.begin, batch.end]).ravel()
        bends = kinks(part.moves, part.profile, batch.grid)
        needed = np.union1d(bends[(bends > 0) & (bends < n - 1)], forced(places, 0, n - 1))
        node = break_points(batch.command, ends, needed, self._dt, self._budget)
        pinned = np.isin(node, ends)
        position = np.column_stack([fit(batch.command, node, pinned), batch.desired[node, 2:]])
        if not np.isfinite(position).all():
            raise LimitError("a compensated position is not finite")
        first = np.searchsorted(node, batch.begin)
        real = np.ones(len(node) - 1, dtype=bool)
        real[first[1:] - 1] = False
        modes = self._modes_of(places, segment_of(places.sample, node), len(real))
        return _Segments(node, pinned, words_of(position, modes, real, ~pinned), modes, first)

    def _modes_of(self, places: Places, at: np.ndarray, count: int) -> Modes:
        """Modes in force for each segment: those after the last line before it."""
        rows = self._modes.then(places.lines.modes(places.e_machine))
        return rows[np.searchsorted(at, np.arange(count), side="right")]

    def _timed(self, segments: _Segments, batch: Batch, bases: list[Limits]) -> tuple[Moves, Profile, np.ndarray]:
        """The written segments as the firmware sees them, what its planner makes of them, and their F words."""
        words, modes = segments.words, segments.modes
        here = np.flatnonzero(words.real)
        unit, factor = words.unit[here], modes.speed_factor[here]
        stop = np.zeros(len(words.real), dtype=bool)
        stop[segments.first[1 if batch.begun else 0 :]] = True
        limits = tuple(dict.fromkeys(bases))
        stretch = np.searchsorted(segments.first, here, side="right") - 1
        state = np.array([limits.index(base) for base in bases])[stretch]
        moves = Moves(
            start=words.begin[here] * (unit[:, None] / SCALE) + modes.offset[here],
            delta=words.delta[here],
            speed=np.ones(len(here)),
            stop=stop[here],
            state=state,
            line=np.zeros(len(here), dtype=np.int64),
            limits=tuple(raised(self._firmware, base) for base in limits),
        )
        wanted = np.diff(segments.node)[here] * self._dt
        asked = wanted.copy()
        asked[0] = max(asked[0] - self._late, 0.5 * asked[0])
        moves, done = timed(moves, asked, self._firmware, lambda v: speed_of(feed_of(v, unit, factor), unit, factor),
                            batch.begun, batch.grid.open_last)
        self._late += float(done.duration.sum() - wanted.sum())
        feed = np.zeros(len(words.real), dtype=np.int64)
        feed[here] = feed_of(moves.speed, unit, factor)
        return moves, done, feed

    def _bases(self, run: Raised, places: Places, starts: np.ndarray, table: tuple[Limits, ...]) -> list[Limits]:
        """Limits of the file in force where the run of each stretch began; raised, they hold for the stretch."""
        before = np.searchsorted(places.lines.number, starts) - 1
        bases = []
        for begins, line in zip(run.begin.tolist(), before.tolist(), strict=True):
            if begins:
                self._run.base = table[places.lines.state[line]] if line >= 0 else self._run.in_force
            bases.append(self._run.base)
        return bases

    def _count(self, segments: _Segments, moves: Moves, done: Profile, batch: Batch, idle: np.ndarray) -> None:
        """Hand the batch to the tally."""
        passed = np.concatenate([[0.0], np.cumsum(idle)])[batch.start]
        rest = np.diff(passed, prepend=-self._rest)
        if batch.begun:
            rest[0] = 0.0
        self._rest = float(idle.sum() - passed[-1])
        number = np.cumsum(segments.words.real) - 1
        self._tally.add(Stretches(
            begin=batch.begin, end=batch.end, rest=np.rint(rest / self._dt).astype(np.int64),
            desired=batch.desired[:, :2], command=batch.command, extruding=batch.extruding,
            first=number[segments.first], start=moves.start, delta=moves.delta, distance=moves.distance,
            wanted=np.diff(segments.node)[segments.words.real] * self._dt, executed=done, dt=self._dt,
        ))  # fmt: skip

    def _emit(self, places: Places, run: Raised, starts: np.ndarray, bases: list[Limits], segments: _Segments | None,
              text: bytes, offsets: np.ndarray, node: np.ndarray, spent: np.ndarray, table: tuple[Limits, ...]) -> None:
        """Write segments and lines in their order."""
        at = segment_of(places.sample, node)
        rises = np.flatnonzero(run.begin)
        place_of = np.concatenate([at, segments.first[rises] if segments else np.zeros(0, dtype=np.int64)])
        number = np.concatenate([places.lines.number, starts[rises] - 0.5])
        order = np.lexsort((number, place_of))
        restated = self._restated(places, at, segments)
        done = 0
        for item in order.tolist():
            cut = int(offsets[place_of[item]])
            if cut > done:
                self._put(text[done:cut])
                done = cut
            if item >= len(at):
                self._put(raising(self._firmware, bases[rises[item - len(at)]]))
            else:
                self._line(places, item, bool(run.line[item]), restated.get(item), table,
                           self.elapsed + float(places.passed[item] + spent[at[item]]))
        self._put(text[done:])

    def _restated(self, places: Places, at: np.ndarray, segments: _Segments | None) -> dict[int, int]:
        """E words of G92 lines inside stretches: E is moving, and the machine is not exactly where the file says."""
        if segments is None:
            return {}
        inner = (places.lines.kind == Kind.MODE) & (places.sample == np.floor(places.sample)) & ~places.lines.e_relative
        return {i: int(segments.words.begin[at[i], E]) for i in np.flatnonzero(inner & (at < len(segments.words.begin))).tolist()}

    def _line(self, places: Places, i: int, raised_here: bool, e_word: int | None, table: tuple[Limits, ...], elapsed: float) -> None:
        lines = places.lines
        restore = b""
        if raised_here and lines.kind[i] == Kind.BARRIER:
            restore = restoring(self._firmware, table[lines.state[i]], float(lines.feed[i]))
        text = kept_text(places, i, raised_here, restore, e_word)
        if self._patch_times and lines.kind[i] == Kind.PROGRESS:
            body = text.rstrip(b"\r\n")
            told = time_line(body)
            if told:
                self.patches.append(Patch(self.written, told, elapsed))
                text = body.ljust(told.room) + text[len(body) :]
        self._put(text)
        if lines.number[i] == 0:
            self._put(self._stamp + b"\n")

    def _put(self, text: bytes) -> None:
        if text:
            self._write(text)
            self.written += len(text)

    def _carry(self, places: Places, due: np.ndarray, part: Part, idle: np.ndarray, spent: float, lines: Listing, dropped: int,
               table: tuple[Limits, ...]) -> None:
        """What the next batch needs to know."""
        if len(part.moves):
            self._e = float(part.moves.start[-1, E] + part.moves.delta[-1, E])
        if len(lines):
            self._run.in_force, self._run.feed = table[lines.state[-1]], float(lines.feed[-1])
        passed = float(idle.sum() + lines.wait.sum())
        self.elapsed += spent + passed
        self.dwelt += float(lines.wait.sum())
        written, held = places[due], places[~due]
        if len(written):
            self._modes = written[-1:].lines.modes(written.e_machine[-1:])
        self._held = replace(held, sample=held.sample - dropped, passed=held.passed - passed) if len(held) else None


def _spent(real: np.ndarray, done: Profile) -> np.ndarray:
    """Time of the segments before each node [s], shape (k + 1,)."""
    duration = np.zeros(len(real))
    duration[real] = done.duration
    return np.concatenate([[0.0], np.cumsum(duration)])
