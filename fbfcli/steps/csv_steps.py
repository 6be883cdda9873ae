"""Steps as CSV: `time,motor,direction`, one line per step in the order of time.

    time,motor,direction
    0.012500000,x,1
    0.012733408,e,-1

Time in seconds, to the nanosecond; direction 1 or -1.
"""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np

from fbfcli.digits import chosen, decimal, rows
from fbfcli.errors import FbfError
from fbfcli.steps.stream import Motors, MotorSteps, Piece, merged, parted
from fbfcli.units import NS_PER_S

HEAD = b"time,motor,direction\n"
DECIMALS = 9
ROW = [("time", "f8"), ("motor", "U16"), ("way", "i1")]


class CsvWriter:
    """Writes a stream as CSV."""

    def __init__(self, motors: Motors):
        self._ends = [b",%s,%d\n" % (name.encode(), way) for name in motors.names for way in (-1, 1)]

    def head(self) -> Iterator[bytes]:
        yield HEAD

    def add(self, piece: Piece) -> Iterator[bytes]:
        """The lines of a piece's steps."""
        time, motor, forward = merged(piece.steps.motors)
        if len(time):
            yield rows(len(time), decimal(time, DECIMALS), chosen(self._ends, 2 * motor + forward))

    def end(self) -> Iterator[bytes]:
        yield b""


def read_csv(data: bytes) -> dict[str, MotorSteps]:
    """The steps of each motor that makes any. Raises FbfError."""
    if not data.startswith(HEAD):
        raise FbfError(f"not a CSV of steps: it begins {data[:30]!r}, not {HEAD!r}")
    if data == HEAD:
        return {}
    try:
        table = np.loadtxt(io.BytesIO(data[len(HEAD) :]), delimiter=",", dtype=ROW, ndmin=1)
    except ValueError as why:
        raise FbfError(f"not a CSV of steps: {why}") from None
    names, motor = np.unique(table["motor"], return_inverse=True)
    time = np.rint(table["time"] * NS_PER_S).astype(np.int64)  # exact: below 2^53
    return dict(zip(names.tolist(), parted(time, motor, table["way"] > 0, len(names)), strict=True))
