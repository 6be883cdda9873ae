"""Steps as Marlin's direct stepping takes them: 256-byte pages and G6 (page format SP_4x4D_128).

Facts from Marlin 2.1: feature/direct_stepping.h and .cpp (page size, segment table, serial frames), module/stepper.cpp
(order of the half bytes), gcode/motion/G6.cpp. A page has 128 segments of two bytes, half a byte per motor in the order
X Y, Z E; its value less 7 is the motor's steps in the segment, spread by the firmware over seven ticks. R of G6 is the
rate of the ticks, set once. On the wire a page is

    "!" | index | 256 bytes | exclusive or of the bytes

at the beginning of a line, and `G6 I<index>` runs it. Indices go round 0 to 15 (STEPPER_PAGES). While all motors stand
for whole pages, `G4 P<ms>` stands for them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from fbfcli.errors import FbfError, LimitError, ProfileError
from fbfcli.steps.stream import Motors, MotorSteps, Piece
from fbfcli.units import NS_PER_S

AXES = 4
SEGMENTS = 128
SIZE = 2 * SEGMENTS
MOST = 7  # steps of a segment, and its ticks
PAGES = 16
MS_PER_S = 1000.0
MARK = b"!"


class PagesWriter:
    """Writes a stream as pages.

    rate : ticks per second
    """

    def __init__(self, motors: Motors, rate: int):
        if len(motors.names) > AXES:
            raise ProfileError(f"a page has {AXES} motors, not {len(motors.names)}")
        self._names, self._rate = motors.names, rate
        self._segment_ns = NS_PER_S * MOST / rate
        self._moved = np.zeros((0, AXES), dtype=np.int64)  # steps of each segment not yet written
        self._first = 0  # number of the first of them
        self._page, self._idle = 0, 0

    def head(self) -> Iterator[bytes]:
        yield b"G6 R%d\n" % self._rate

    def add(self, piece: Piece) -> Iterator[bytes]:
        """The pages that are full."""
        past = int(piece.steps.end / self._segment_ns)
        self._count(piece)
        yield from self._written(max(past - self._first, 0) // SEGMENTS)

    def _count(self, piece: Piece) -> None:
        """Add a piece's steps to their segments."""
        at = [(one.time / self._segment_ns).astype(np.int64) - self._first for one in piece.steps.motors]
        end = max([int(one[-1]) + 1 for one in at if len(one)], default=0)
        end = max(end, int(piece.steps.end / self._segment_ns) - self._first)
        more = np.zeros((max(end - len(self._moved), 0), AXES), dtype=np.int64)
        self._moved = np.concatenate([self._moved, more])
        for i, (segment, one) in enumerate(zip(at, piece.steps.motors, strict=True)):
            np.add.at(self._moved[:, i], segment, np.where(one.forward, 1, -1))

    def _written(self, pages: int) -> Iterator[bytes]:
        moved, self._moved = self._moved[: pages * SEGMENTS], self._moved[pages * SEGMENTS :]
        fast = np.argwhere(np.abs(moved) > MOST)
        if len(fast):
            segment, i = fast[0].tolist()
            time = (self._first + segment) * self._segment_ns / NS_PER_S
            raise LimitError(
                f"at {time:.6f} s motor {self._names[i]} would make {abs(moved[segment, i])} steps in {MOST} ticks: "
                f"give a higher --rate than {self._rate}"
            )
        self._first += len(moved)
        moved = moved.reshape(pages, SEGMENTS, AXES)
        stands: np.ndarray = (moved == 0).all(axis=(1, 2))
        half = (moved + MOST).astype(np.uint8)
        data = (half[:, :, 0::2] << 4 | half[:, :, 1::2]).reshape(pages, SIZE)
        check = np.bitwise_xor.reduce(data, axis=1)
        for i in range(pages):
            if stands[i]:
                self._idle += 1
                continue
            yield from self._rest()
            index = bytes([self._page])
            yield MARK + index + data[i].tobytes() + check[i].tobytes() + b"G6 I%d\n" % self._page
            self._page = (self._page + 1) % PAGES

    def _rest(self) -> Iterator[bytes]:
        """A dwell for the pages in which nothing moved."""
        if self._idle:
            yield b"G4 P%d\n" % round(self._idle * SEGMENTS * self._segment_ns * MS_PER_S / NS_PER_S)
            self._idle = 0

    def end(self) -> Iterator[bytes]:
        """The last page, filled up with rest."""
        short = -len(self._moved) % SEGMENTS
        self._moved = np.concatenate([self._moved, np.zeros((short, AXES), dtype=np.int64)])
        yield from self._written(len(self._moved) // SEGMENTS)
        yield from self._rest()


_HEAD = re.compile(rb"G6 R(\d+)\n")
_DWELL = re.compile(rb"G4 P(\d+)\n")
_RUN = re.compile(rb"G6 I(\d+)\n")
# ticks of a segment at which 1 to 7 steps come, as in the firmware's table
_TICKS = ((), (3,), (2, 6), (0, 1, 4), (0, 1, 3, 5), (0, 1, 2, 4, 6), (0, 1, 2, 4, 5, 6), (0, 1, 2, 3, 4, 5, 6))


def read_pages(data: bytes) -> dict[str, MotorSteps]:
    """The steps that the firmware makes of the pages, motors x y z e. Raises FbfError."""
    if not (head := _HEAD.match(data)):
        raise FbfError(f"not a stream of pages: it begins {data[:20]!r}")
    segment_s = MOST / int(head[1])
    moved = _segments(data, head.end(), SEGMENTS * segment_s)
    return {name: _spread(moved[:, i], segment_s) for i, name in enumerate("xyze")}


def _segments(data: bytes, at: int, page_s: float) -> np.ndarray:
    """Steps of the four motors in every segment, shape (segments, 4)."""
    found = [np.zeros((0, AXES), dtype=np.int64)]
    while at < len(data):
        if dwell := _DWELL.match(data, at):
            pages = round(int(dwell[1]) / MS_PER_S / page_s)
            found.append(np.zeros((pages * SEGMENTS, AXES), dtype=np.int64))
            at = dwell.end()
            continue
        run = _RUN.match(data, at + 3 + SIZE)
        if data[at : at + 1] != MARK or not run or int(run[1]) != data[at + 1]:
            raise FbfError(f"byte {at}: neither a page and its G6 nor a dwell")
        page = np.frombuffer(data[at + 2 : at + 2 + SIZE], dtype=np.uint8)
        if np.bitwise_xor.reduce(page) != data[at + 2 + SIZE]:
            raise FbfError(f"byte {at}: the page's checksum is wrong")
        found.append(np.stack([page >> 4, page & 15], axis=1).reshape(SEGMENTS, AXES).astype(np.int64) - MOST)
        at = run.end()
    return np.concatenate(found)


def _spread(moved: np.ndarray, segment_s: float) -> MotorSteps:
    """The steps of one motor's segments, shape (segments,), on the firmware's ticks."""
    size = np.abs(moved)
    time, forward = [], []
    for count in range(1, MOST + 1):
        here = np.flatnonzero(size == count)
        ticks = here[:, None] + np.array(_TICKS[count]) / MOST
        time.append(ticks.ravel() * segment_s * NS_PER_S)
        forward.append(np.repeat(moved[here] > 0, count))
    at, way = np.concatenate(time), np.concatenate(forward)
    order = np.argsort(at)
    return MotorSteps(np.rint(at[order]).astype(np.int64), way[order])
