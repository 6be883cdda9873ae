"""Positions at a fixed rate, one line per period: what LinuxCNC's halstreamer reads (man halstreamer, streamer_usr.c).

A line holds a number for each pin, separated by blanks; each motor's position [mm, six decimals]. Of three motors:

    loadrt streamer depth=4000 cfg=fff
    halstreamer < part.positions.txt

    10.000000 20.000000 0.300000
    10.002500 20.000000 0.300000

Between samples the position is that of `curve`; at the trajectory's own rate a line is a sample. The first line is the
stream's beginning, the last is where it ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import floor

import numpy as np

from fbfcli.digits import decimal, fixed, rows
from fbfcli.errors import FbfError
from fbfcli.steps.curve import position
from fbfcli.steps.stream import Motors, Piece
from fbfcli.units import NS_PER_S

DECIMALS = 6
LINES_AT_ONCE = 8192  # a long dwell is many lines
EPS_PERIOD = 1e-9


class PositionsWriter:
    """Writes a stream as positions.

    rate : lines per second
    dt   : the trajectory's period [s]
    """

    def __init__(self, motors: Motors, rate: float, dt: float):
        self._dt, self._step = dt, 1.0 / (rate * dt)  # of a line [periods]
        self._tick = np.zeros(0, dtype=np.int64)
        self._q = np.zeros((0, len(motors.names)))  # samples that the next piece needs again
        self._next = 0  # line
        self._end = 0.0  # of the stream [periods]

    def head(self) -> Iterator[bytes]:
        yield b""

    def add(self, piece: Piece) -> Iterator[bytes]:
        """Lines up to the last sample but one: the curve there depends on the last."""
        if not len(self._tick) and len(piece.tick):
            self._tick, self._q = piece.tick[:1] - 1, piece.position[:1]
        self._tick = np.concatenate([self._tick, piece.tick])
        self._q = np.concatenate([self._q, piece.position])
        if len(self._tick) > 2:
            yield from self._lines(float(self._tick[-2]) - EPS_PERIOD)
            self._tick, self._q = self._tick[-3:], self._q[-3:]
        self._end = piece.steps.end / NS_PER_S / self._dt

    def end(self) -> Iterator[bytes]:
        """The last lines."""
        if len(self._tick):
            yield from self._lines(self._end + EPS_PERIOD)

    def _lines(self, until: float) -> Iterator[bytes]:
        """The lines whose time is not after `until` [periods]."""
        stop = floor(until / self._step) + 1
        for first in range(self._next, stop, LINES_AT_ONCE):
            at = self._step * np.arange(first, min(first + LINES_AT_ONCE, stop))
            i = np.clip(np.searchsorted(self._tick, at + EPS_PERIOD, side="right") - 1, 0, len(self._tick) - 2)
            q = position(self._q, i + np.clip(at - self._tick[i], 0.0, 1.0))
            cells = [decimal(np.rint(column * 10**DECIMALS).astype(np.int64), DECIMALS) for column in q.T]
            between = [fixed(b" ")] * (len(cells) - 1) + [fixed(b"\n")]
            yield rows(len(at), *(cell for pair in zip(cells, between, strict=True) for cell in pair))
        self._next = max(self._next, stop)


def read_positions(data: bytes) -> np.ndarray:
    """Positions, shape (lines, pins), by halstreamer's rules. Raises FbfError.

    A field is skipped to over blanks and read by strtod; a blank or the line's end must follow it. Lines that begin
    with # are comments.
    """
    found: list[list[float]] = []
    for number, line in enumerate(data.decode("latin-1").splitlines(), 1):
        if line.startswith("#"):
            continue
        try:
            found.append([float(field) for field in line.split()])
        except ValueError:
            raise FbfError(f"line {number}: not a row of positions: {line[:40]!r}") from None
        if len(found[-1]) != len(found[0]) or not found[0]:
            raise FbfError(f"line {number}: {len(found[-1])} positions, {len(found[0])} in the line before")
    return np.array(found)
