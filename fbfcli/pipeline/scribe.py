"""From segments to text: the lines of the file between them, limits raised and put back, times to be filled in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing
from fbfcli.gcode.placement import Places, after, place, segment_of
from fbfcli.gcode.runs import Raised, is_special, joints, kept_text, raised_where, raising, restoring
from fbfcli.gcode.stamp import TimeLine, time_line
from fbfcli.gcode.write import power_on_modes, segment_lines
from fbfcli.motion.moves import E
from fbfcli.motion.planner import Part
from fbfcli.pipeline.commander import Batch
from fbfcli.pipeline.segmenter import Segmenter, Segments
from fbfcli.printer import Limits
from fbfcli.verify.tally import Stretches, Tally

MODE, PROGRESS = int(Kind.MODE), int(Kind.PROGRESS)


@dataclass(frozen=True)
class Patch:
    """A time to be filled in: where in the output, what, and the print time before it [s]."""

    offset: int
    line: TimeLine
    elapsed: float


@dataclass(frozen=True)
class _Page:
    """What is written of one batch: lines, the stretches they stand between, and the text of the segments.

    places  : Places                         lines whose time has come
    at      : ndarray of int, shape (k,)     segment before which each stands
    run     : Raised
    bases   : list of Limits                 per stretch, in force when its run began
    rise_at, rise_before : ndarray of int    where limits are raised: before this segment, before this line
    text    : bytes                          of the segments
    offsets : ndarray of int                 where each segment begins in it
    elapsed : ndarray                        time of the segments before each [s]
    table   : tuple of Limits                that `places.lines.state` counts in
    starts  : ndarray of int, shape (s,)     line that each stretch began with
    before  : Limits                         raised when the batch began
    """

    places: Places
    at: np.ndarray
    run: Raised
    bases: list[Limits]
    rise_at: np.ndarray
    rise_before: np.ndarray
    text: bytes
    offsets: np.ndarray
    elapsed: np.ndarray
    table: tuple[Limits, ...]
    starts: np.ndarray
    before: Limits

    def base_of(self, i: int) -> Limits:
        """The limits that are raised where line i stands."""
        stretch = int(np.searchsorted(self.starts, self.places.lines.number[i])) - 1
        return self.bases[stretch] if stretch >= 0 else self.before


class Scribe:
    """Writes one file, batch by batch."""

    def __init__(
        self,
        firmware: str,
        limits: Limits,
        segmenter: Segmenter,
        tally: Tally,
        write: Callable[[bytes], object],
        stamp: bytes,
        patch_times: bool,
    ):
        self._firmware, self._segmenter, self._tally = firmware, segmenter, tally
        self._write, self._stamp, self._patch_times = write, stamp, patch_times
        self._raised = False
        self._base = self._in_force = limits  # where the run began; of the file, now
        self._feed = np.nan  # F that the file has in force
        self._held: Places | None = None  # lines whose time has not come
        self._modes = power_on_modes()  # after the last line written
        self._e = 0.0  # of the machine, after the last move [mm]
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
        places = after(self._held, place(lines, part.moves, inside, batch.grid, idle, self._e))
        due = places.sample < (len(batch.command) - 0.25 if batch.grid.open_last else np.inf)
        page, segments = self._page(batch, part, places[due], table)
        rest = self._rests(batch, part, idle, lines)
        if segments:
            self._tell(batch, segments, rest)
        self._emit(page, segments)
        self._carry(places, due, part, idle, page, lines, batch.dropped)

    def finish(self) -> None:
        """Put the limits back at the end of the file."""
        if self._raised:
            self._put(restoring(self._firmware, self._in_force, self._base, self._feed))
            self._raised = False

    def _page(
        self, batch: Batch, part: Part, places: Places, table: tuple[Limits, ...]
    ) -> tuple[_Page, Segments | None]:
        starts = batch.line
        number = places.lines.number
        run = raised_where(number, number[places.barrier], starts, self._raised)
        base = self._base
        bases = self._bases(run, places, starts, table)
        none = np.zeros(1, dtype=np.int64)
        if not len(batch.command):
            at = segment_of(places.sample, none)
            return _Page(places, at, run, bases, none[:0], none[:0], b"", none, np.zeros(1), table, starts, base), None
        segments = self._segmenter.segments(batch, part, places, self._modes, bases)
        text, offsets = segment_lines(segments.words, segments.modes, segments.feed)
        at = segment_of(places.sample, segments.node)
        rise_at, first_line = segments.first[run.begin], starts[run.begin]
        before = np.searchsorted(number, first_line).clip(
            np.searchsorted(at, rise_at), np.searchsorted(at, rise_at, side="right")
        )
        page = _Page(places, at, run, bases, rise_at, before, text, offsets, segments.elapsed, table, starts, base)
        return page, segments

    def _bases(self, run: Raised, places: Places, starts: np.ndarray, table: tuple[Limits, ...]) -> list[Limits]:
        """Limits of the file in force where the run of each stretch began; raised, they hold for the stretch."""
        before = np.searchsorted(places.lines.number, starts) - 1
        bases = []
        for begins, line in zip(run.begin.tolist(), before.tolist(), strict=True):
            if begins:
                self._base = table[places.lines.state[line]] if line >= 0 else self._in_force
            bases.append(self._base)
        return bases

    def _rests(self, batch: Batch, part: Part, idle: np.ndarray, lines: Listing) -> np.ndarray:
        """Time of moves outside stretches and of dwells before each stretch [s], shape (s,)."""
        moved, waited = (np.concatenate([[0.0], np.cumsum(each)]) for each in (idle, lines.wait))
        passed = moved[batch.start] + waited[np.searchsorted(lines.number, part.moves.line[batch.start])]
        rest = np.diff(passed, prepend=-self._rest)
        self._rest = float(moved[-1] + waited[-1] + (self._rest if not len(passed) else -passed[-1]))
        return rest

    def _tell(self, batch: Batch, segments: Segments, rest: np.ndarray) -> None:
        """Hand the batch to the tally."""
        number = np.cumsum(segments.words.real) - 1
        dt = self._segmenter.dt
        self._tally.add(
            Stretches(
                begin=batch.begin,
                end=batch.end,
                rest=np.rint(rest / dt).astype(np.int64),
                begun=batch.begun,
                goes_on=batch.goes_on,
                desired=batch.desired[:, :2],
                command=batch.command,
                extruding=batch.extruding,
                line=batch.asked,
                filament=batch.filament,
                first=number[segments.first],
                start=segments.moves.start,
                delta=segments.moves.delta,
                distance=segments.moves.distance,
                wanted=segments.wanted,
                executed=segments.done,
                late=segments.late,
                dt=dt,
                place=batch.place,
            )
        )

    def _emit(self, page: _Page, segments: Segments | None) -> None:
        """Write segments and lines in their order: lines that stay as they are in one piece with their neighbours."""
        places, lines = page.places, page.places.lines
        restated = self._restated(page, segments)
        special = is_special(places, page.run.line) | (lines.number == 0)
        special[list(restated)] = True
        special[lines.kind == PROGRESS] |= self._patch_times
        breaks = joints(lines, special) | (np.diff(page.at, prepend=-1) != 0)
        breaks[page.rise_before[page.rise_before < len(lines)]] = True
        rising = np.flatnonzero(page.run.begin).tolist()
        rises = list(zip(page.rise_before.tolist(), page.rise_at.tolist(), rising, strict=True))
        done = 0
        for i, j in pairwise(np.append(np.flatnonzero(breaks), len(lines)).tolist()):
            while rises and rises[0][0] <= i:
                _, at, stretch = rises.pop(0)
                done = self._rise(page, done, at, stretch)
            done = self._up_to(page, done, int(page.at[i]))
            if special[i]:
                self._line(page, i, restated.get(i))
            else:
                self._put(lines.text[lines.begin[i] : lines.end[j - 1]])
        for _, at, stretch in rises:
            done = self._rise(page, done, at, stretch)
        self._put(page.text[done:])

    def _rise(self, page: _Page, done: int, at: int, stretch: int) -> int:
        """Raise the limits before segment `at`."""
        done = self._up_to(page, done, at)
        self._put(raising(self._firmware, page.bases[stretch]))
        return done

    def _up_to(self, page: _Page, done: int, segment: int) -> int:
        """Write the segments before `segment`, and say how far their text has been written."""
        cut = int(page.offsets[segment])
        if cut > done:
            self._put(page.text[done:cut])
        return max(cut, done)

    def _restated(self, page: _Page, segments: Segments | None) -> dict[int, int]:
        """E words of G92 lines inside stretches: E is moving, and the machine is not exactly where the file says."""
        if segments is None:
            return {}
        inner = (page.places.lines.kind == MODE) & (page.places.sample == np.floor(page.places.sample))
        inner &= page.at < len(segments.words.begin)
        return {i: int(segments.words.begin[page.at[i], E]) for i in np.flatnonzero(inner).tolist()}

    def _line(self, page: _Page, i: int, e_word: int | None) -> None:
        """Write one line that is not simply passed on."""
        places, lines = page.places, page.places.lines
        raised_here, restore = bool(page.run.line[i]), b""
        if raised_here and places.barrier[i]:
            restore = restoring(self._firmware, page.table[lines.state[i]], page.base_of(i), float(lines.feed[i]))
        text = kept_text(places, i, raised_here, restore, e_word)
        if self._patch_times and lines.kind[i] == PROGRESS:
            body = text.rstrip(b"\r\n")
            told = time_line(body)
            if told:
                elapsed = self.elapsed + float(places.passed[i] + page.elapsed[page.at[i]])
                self.patches.append(Patch(self.written, told, elapsed))
                text = body.ljust(told.room) + text[len(body) :]
        self._put(text)
        if lines.number[i] == 0:
            self._put(self._stamp + b"\n")

    def _put(self, text: bytes) -> None:
        if text:
            self._write(text)
            self.written += len(text)

    def _carry(
        self,
        places: Places,
        due: np.ndarray,
        part: Part,
        idle: np.ndarray,
        page: _Page,
        lines: Listing,
        dropped: int,
    ) -> None:
        """What the next batch needs to know."""
        self._raised = page.run.after
        if len(part.moves):
            self._e = float(part.moves.start[-1, E] + part.moves.delta[-1, E])
        if len(lines):
            self._feed = float(lines.feed[-1])
        if len(page.places):
            self._in_force = page.table[page.places.lines.state[-1]]
            self._modes = page.places[-1:].lines.modes(page.places.e_machine[-1:])
        passed = float(idle.sum() + lines.wait.sum())
        self.elapsed += float(page.elapsed[-1]) + passed
        self.dwelt += float(lines.wait.sum())
        held = places[~due]
        self._held = replace(held, sample=held.sample - dropped, passed=held.passed - passed) if len(held) else None
