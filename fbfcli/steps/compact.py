"""The compact format: parabolas as integers of varying length, some tenths of a byte per step. See docs/steps.md.

    head   "FBFSTEPS" 1 | tolerance [ns] | number of motors | for each: steps per mm (float64), name ("x" and 0)
    frame  1 | motor | bytes of the payload | payload: wait, interval, add (zigzag), count * 2 + forward, repeated
    end    0 | for each motor: its steps

`wait` is the time from the motor's step before to the parabola's first step (zigzag; the first counts from 0).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np

from fbfcli.errors import FbfError
from fbfcli.steps.parabolas import Parabolas, fitted
from fbfcli.steps.stream import Motors, MotorSteps, Piece, joined, no_steps
from fbfcli.steps.varints import packed, unpacked, unzigzag, zigzag

MAGIC = b"FBFSTEPS\x01"
TOLERANCE_NS = 1000
END, FRAME = 0, 1
FIELDS = 4


class CompactWriter:
    """Writes a stream in the compact format."""

    def __init__(self, motors: Motors, tolerance: int = TOLERANCE_NS):
        self._motors, self._tolerance = motors, tolerance
        self._last = [0] * len(motors.names)  # time of the last step as it will be read [ns]
        self._counts = [0] * len(motors.names)

    def head(self) -> Iterator[bytes]:
        names, rates = self._motors.names, self._motors.steps_per_mm
        yield MAGIC + _numbers(self._tolerance, len(names))
        yield b"".join(struct.pack("<d", rate) + name.encode() + b"\0" for name, rate in zip(names, rates, strict=True))

    def add(self, piece: Piece) -> Iterator[bytes]:
        """A frame for each motor that steps."""
        for i, steps in enumerate(piece.steps.motors):
            if len(steps):
                self._counts[i] += len(steps)
                yield self._frame(i, fitted(steps, self._tolerance))

    def _frame(self, i: int, found: Parabolas) -> bytes:
        last = found.last()
        wait = found.begin - np.concatenate([[self._last[i]], last[:-1]])
        self._last[i] = int(last[-1])
        law = [zigzag(wait), zigzag(found.interval), zigzag(found.add), 2 * found.count + found.forward]
        payload = packed(np.column_stack(law).ravel())
        return _numbers(FRAME, i, len(payload)) + payload

    def end(self) -> Iterator[bytes]:
        """The motors' totals, by which a reader knows that nothing is missing."""
        yield _numbers(END, *self._counts)


def _numbers(*values: int) -> bytes:
    return packed(np.array(values, dtype=np.int64))


class _Reader:
    """Goes through the bytes of a stream."""

    def __init__(self, data: bytes):
        self._data, self._at = data, len(MAGIC)

    def number(self) -> int:
        begin = self._at
        while self._data[self._at] >= 0x80:
            self._at += 1
        self._at += 1
        return int(unpacked(self._data[begin : self._at])[0])

    def take(self, size: int) -> bytes:
        data = self._data[self._at : self._at + size]
        if len(data) < size:
            raise ValueError("the file is cut off")
        self._at += size
        return data

    def name(self) -> str:
        return self.take(self._data.index(b"\0", self._at) + 1 - self._at)[:-1].decode()


def read_compact(data: bytes) -> dict[str, MotorSteps]:
    """The steps of each motor. Raises FbfError."""
    if not data.startswith(MAGIC):
        raise FbfError(f"not a compact step stream: it begins {data[:9]!r}, not {MAGIC!r}")
    try:
        return _read(_Reader(data))
    except (ValueError, IndexError, struct.error) as why:
        raise FbfError(f"a damaged step stream: {why}") from None


def _read(reader: _Reader) -> dict[str, MotorSteps]:
    reader.number()  # the tolerance
    names = []
    for _ in range(reader.number()):
        reader.take(8)
        names.append(reader.name())
    found: list[list[MotorSteps]] = [[no_steps()] for _ in names]
    last = [0] * len(names)
    while reader.number() == FRAME:
        i = reader.number()
        wait, interval, add, count = unpacked(reader.take(reader.number())).reshape(-1, FIELDS).T
        begin, count, forward = np.zeros_like(wait), count >> 1, (count & 1).astype(bool)
        law = Parabolas(begin, unzigzag(interval), unzigzag(add), count, forward)
        length = law.last()  # from the first step of each to its last
        begin += last[i] + np.cumsum(unzigzag(wait)) + np.cumsum(length) - length
        last[i] = int(begin[-1] + length[-1])
        found[i].append(law.steps())
    steps = [joined(parts) for parts in found]
    if any(len(one) != reader.number() for one in steps):
        raise ValueError("steps are missing")
    return dict(zip(names, steps, strict=True))
