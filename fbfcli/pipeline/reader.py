"""From text to planned moves: scanned, interpreted, sorted into compensated and not, and planned in parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import GcodeError
from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.interpret import Block, initial_state, interpret
from fbfcli.gcode.listing import Listing, join, listing
from fbfcli.gcode.raised import raised
from fbfcli.gcode.runs import raised_where
from fbfcli.gcode.scan import scan
from fbfcli.motion.limit_table import LimitTable, compensated
from fbfcli.motion.moves import Moves, moves_xy
from fbfcli.motion.planner import Part, Planner, no_part
from fbfcli.motion.stretches import compensable, with_rests
from fbfcli.motion.travel import check_travel
from fbfcli.pipeline.settings import Settings
from fbfcli.printer import Limits, Printer
from fbfcli.verify.firmware import QueuePlanner


@dataclass(frozen=True)
class Portion:
    """A part of the motion with its lines.

    part   : Part
    inside : ndarray of bool, shape (n,)   moves that are compensated
    lines  : Listing                       lines of these moves, and those before the next move
    table  : tuple of Limits               that `lines.state` counts in
    """

    part: Part
    inside: np.ndarray
    lines: Listing
    table: tuple[Limits, ...]


class Reader:
    """One file, read and planned as a stream.

    as_written : no move is to be compensated; --accel and --velocity hold for moves of X and Y all the same
    planner    : of moves as they are executed; None: one that sees as far ahead as it needs
    """

    def __init__(self, printer: Printer, settings: Settings, as_written: bool = False,
                 planner: Planner | QueuePlanner | None = None):  # fmt: skip
        self._printer, self._settings, self._as_written = printer, settings, as_written
        self._planner, self._as_sliced = planner or Planner(printer.firmware), Planner(printer.firmware)
        self._limits = LimitTable()
        self._known = self._inside = self._raised = False  # after the last line, move and line
        self._lines: list[Listing] = []
        self.count = 0  # lines
        self.moves = 0
        self.left_alone = 0  # moves of X or Y that could not be compensated
        self.time_as_sliced = 0.0  # s, as the firmware would print the file unchanged; not told where it does
        self.warnings: list[str] = []

    def portions(self, chunks: Iterable[bytes], progress: Callable[[int], None]) -> Iterator[Portion]:
        """The file in portions, in order. Raises GcodeError without the file's name."""
        state = initial_state(self._printer)
        read = 0
        for text in chunks:
            lines = scan(text, self.count)
            block, state = interpret(lines, state, self._printer)
            self.count += len(lines)
            yield from self._block(block)
            read += len(text)
            progress(read)
        if not self.count:
            raise GcodeError("the file is empty")
        nothing = no_part(self._limits.limits).moves
        yield from self._planned(nothing, np.zeros(0, dtype=bool), state.limits, last=True)
        self._tell_time(nothing, last=True)
        if self._lines:
            yield Portion(no_part(self._limits.limits), np.zeros(0, dtype=bool), join(self._lines), state.limits)

    def _block(self, block: Block) -> Iterator[Portion]:
        self.warnings += block.warnings
        lines, moves, table = listing(block), block.moves, block.moves.limits
        self._lines.append(lines)
        self.moves += len(moves)
        row = moves.line - block.lines.first
        known = np.concatenate([[self._known], block.known])
        check_travel(moves, known[row + 1], tuple(axis.travel for axis in self._printer.axes))
        inside = compensable(moves, known[row], self._settings.acceleration)
        inside &= not self._as_written
        self.left_alone += int(np.count_nonzero(~inside & moves_xy(moves)))
        self._known = bool(known[-1])
        self._tell_time(
            replace(moves, state=self._limits.index(table)[moves.state], limits=self._limits.limits), last=False
        )
        rested = with_rests(moves, inside, self._inside)
        if len(inside):
            self._inside = bool(inside[-1])
        as_written = ~inside & moves_xy(moves)
        barrier = np.union1d(lines.number[lines.kind == int(Kind.BARRIER)], moves.line[as_written])
        run = raised_where(moves.line, barrier, moves.line[inside], self._raised)
        self._raised = run.after
        planned = self._in_force(rested, inside, run.line & ~as_written, table)
        yield from self._planned(planned, inside, table, last=False)

    def _in_force(
        self, moves: Moves, inside: np.ndarray, raised_before: np.ndarray, table: tuple[Limits, ...]
    ) -> Moves:
        """The moves under the limits they will be planned with: compensated ones those of the settings."""
        wanted = self._limits.index(
            tuple(compensated(one, self._settings.acceleration, self._settings.velocity) for one in table)
        )
        in_run = self._limits.index(tuple(raised(self._printer.firmware, one) for one in table))
        plain = self._limits.index(table)
        if self._as_written and (self._settings.acceleration or self._settings.velocity):
            inside = moves_xy(moves)
        state = np.where(inside, wanted[moves.state], np.where(raised_before, in_run[moves.state], plain[moves.state]))
        return replace(moves, state=state, limits=self._limits.limits)

    def _planned(self, moves: Moves, inside: np.ndarray, table: tuple[Limits, ...], last: bool) -> Iterator[Portion]:
        for part in self._planner.feed(moves, inside, last):
            waiting = join(self._lines)
            own, later = waiting.split(int(part.next.line[0])) if part.next is not None else (waiting, waiting[:0])
            self._lines = [later] if len(later) else []
            yield Portion(part, part.tag.astype(bool), own, table)

    def _tell_time(self, moves: Moves, last: bool) -> None:
        if self._as_written:
            return
        tag = np.zeros(len(moves), dtype=bool)
        self.time_as_sliced += sum(
            float(part.profile.duration.sum()) for part in self._as_sliced.feed(moves, tag, last)
        )
