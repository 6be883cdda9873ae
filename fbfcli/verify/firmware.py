"""How a firmware executes the moves of a file as they are written: a planner with the queue that it really has.

Klipper sees as far ahead as it needs: `motion.planner`. Marlin (Marlin/src/module/planner.cpp) and RepRapFirmware
(src/Movement/DDARing.cpp) look ahead over the blocks in their queue. When a block begins, the speed it ends at is
settled from the blocks that are there then, as if the last of them were the last of all: where a queue is too short for
the way to a stop, a print goes slower than its limits allow.

Marlin besides: moves of under six steps are not queued, the next one starts where the last queued one ended; a first
block waits for two more, at most 0.1 s; the first starts at the speed from which it may halt at once, the last ends at
the minimum planner speed; a block that takes less than the minimum segment time (M205 B) is stretched while the queue
is less than half full, which depends on how fast lines come: one every 1 / segments_per_second. Its steps are exact in
number, their rounding within a block is not modelled. RepRapFirmware settles blocks 0.1 s before they begin, up to half
its ring, and waits 10 ms for more before it begins to move.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fbfcli.motion.junctions import MARLIN_MIN_W
from fbfcli.motion.kinematics import Kinematics, kinematics_of
from fbfcli.motion.moves import Moves
from fbfcli.motion.planner import Part, Planner, divided, in_parts, joined
from fbfcli.printer import Printer
from fbfcli.verify.block_queue import BlockQueue, Queue
from fbfcli.verify.merged_moves import Merging

MARLIN_BLOCKS = 16  # BLOCK_BUFFER_SIZE; 32 in some builds for 32-bit boards
MARLIN_SEGMENT_S = 0.02  # DEFAULT_MINSEGMENTTIME
MARLIN_WAITS_S, MARLIN_WAITS_FOR = 0.1, 2  # BLOCK_DELAY_FOR_1ST_MOVE, and the blocks that end it
REPRAP_BLOCKS = 40  # of a Duet 2; 60 of a Duet 3 (M595)
REPRAP_AHEAD_S = 0.1  # UsualMinimumPreparedTime
REPRAP_WAITS_S = 0.01  # grace period before a machine that stands begins to move (M595 R)


def planner_of(printer: Printer, lines_per_second: float | None = None, blocks: int | None = None,
               segment_s: float | None = None) -> Planner | QueuePlanner:  # fmt: skip
    """The planner of a printer that executes a file as it is written.

    lines_per_second : how fast moves come; None: as the profile says
    blocks           : of its queue; None: as the firmware is usually built
    segment_s        : Marlin's minimum segment time (M205 B) [s]; None: its default
    """
    if printer.firmware == "klipper":
        return Planner(printer.firmware)
    period = 1.0 / (lines_per_second or printer.segments_per_second)
    if printer.firmware == "marlin":
        queue = Queue(
            blocks or MARLIN_BLOCKS,
            period,
            end_w=MARLIN_MIN_W,
            segment_s=MARLIN_SEGMENT_S if segment_s is None else segment_s,
            first_waits_s=MARLIN_WAITS_S,
            first_waits_for=MARLIN_WAITS_FOR,
        )
        rates = tuple(axis.steps_per_mm for axis in printer.axes)
        return QueuePlanner("marlin", queue, Merging(_motors(printer), rates, printer.e_steps_per_mm))
    queue = Queue(blocks or REPRAP_BLOCKS, period, ahead_s=REPRAP_AHEAD_S, first_waits_s=REPRAP_WAITS_S)
    return QueuePlanner(printer.firmware, queue, None)


def _motors(printer: Printer) -> Kinematics | None:
    """None: the axes are the motors, or nearly so (a delta's moves are cut into pieces before they are queued)."""
    return kinematics_of(printer) if printer.kinematics == "corexy" else None


class QueuePlanner:
    """The planner of one file, fed with its moves; takes the place of `motion.planner.Planner`.

    merging : what the firmware does with moves of a few steps; None: it queues them
    """

    def __init__(self, firmware: str, queue: Queue, merging: Merging | None):
        self._merging = merging
        self._blocks = BlockQueue(firmware, queue)
        self._waiting: tuple[Moves, np.ndarray] | None = None

    def feed(self, moves: Moves, tag: np.ndarray, last: bool) -> Iterator[Part]:
        """Parts that are final with these moves; `last`: no more will come."""
        if self._merging is not None:
            moves, tag = self._merging.merged(moves, tag)
        moves, tag = divided(moves, tag)
        if self._waiting is not None:
            moves, tag = joined(self._waiting[0], moves), np.concatenate([self._waiting[1], tag])
        self._waiting = None
        if not len(moves):
            return
        timing, speed = self._blocks.executed(moves, last)
        n = len(timing)
        if n < len(moves):
            self._waiting = moves[n:], tag[n:]
        stretched = replace(moves, speed=np.concatenate([speed, moves.speed[n:]]))
        yield from in_parts(stretched, tag, timing)
