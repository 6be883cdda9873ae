"""Numbers as text by array code: eight bytes at a time, looked up in tables.

A line is a row of pieces of eight bytes. Bytes that are zero are not written: they are taken out of all rows at once. A
cell is a list of pieces, each an array of shape (n,) or the same for all rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

PIECE = np.dtype("<u8")  # eight bytes, the first one lowest
AT_ONCE = 16_384  # rows: what stays in the processor's cache
FIVE = 100_000  # a piece has room for five digits, behind three bytes for what comes before them

Cell = list[np.ndarray | np.uint64]


@cache
def tables() -> tuple[np.ndarray, np.ndarray]:
    """A piece for each number below FIVE: as it is written, and with leading zeros."""
    number = np.arange(FIVE)
    padded, short = (np.zeros((FIVE, 8), dtype=np.uint8) for _ in range(2))
    padded[:, 3:] = short[:, 3:] = number[:, None] // 10 ** np.arange(4, -1, -1) % 10 + ord("0")
    for column in range(4):  # leading zeros, but for the last
        short[number < 10 ** (4 - column), 3 + column] = 0
    return short.view(PIECE).ravel(), padded.view(PIECE).ravel()


@cache
def _behind_point(digits: int) -> np.ndarray:
    """A piece for each number of so many digits, at most five: the point and all of them."""
    pieces = tables()[1][: 10**digits].copy().view(np.uint8).reshape(-1, 8)
    pieces[:, : 8 - digits] = 0
    pieces[:, 7 - digits] = ord(".")
    return pieces.view(PIECE).ravel()


def piece(text: bytes) -> np.uint64:
    """At most eight characters."""
    return np.uint64(np.frombuffer(text.ljust(8, b"\0"), PIECE)[0])


def fixed(text: bytes) -> Cell:
    """The same text in every row."""
    return [piece(text[i : i + 8]) for i in range(0, len(text), 8)]


def chosen(texts: Sequence[bytes], which: np.ndarray) -> Cell:
    """One of several texts in each row, `which` of shape (n,)."""
    width = max(map(len, texts))
    return [np.array([piece(text[i : i + 8]) for text in texts])[which] for i in range(0, width, 8)]


def decimal(value: np.ndarray, places: int = 0) -> Cell:
    """Integers in units of the last of `places` decimals, at most nine, shape (n,): -1234 at 2 places is -12.34."""
    size = np.abs(value)
    whole, part = _parted(size, 10**places)
    cell = _whole(whole)
    cell[0] = cell[0] | np.where(value < 0, piece(b"-"), np.uint64(0))
    if places > 5:
        first, last = _parted(part, FIVE)
        return [*cell, _behind_point(places - 5)[first], tables()[1][last]]
    return [*cell, _behind_point(places)[part]] if places else cell


def only(cell: Cell, where: np.ndarray) -> Cell:
    """A cell that is written in some rows, bool, shape (n,)."""
    return [np.where(where, each, np.uint64(0)) for each in cell]


def rows(count: int, *cells: Cell) -> bytes:
    """The text of `count` rows, cell after cell."""
    pieces = [each for cell in cells for each in cell]
    table = np.empty((min(count, AT_ONCE), len(pieces)), dtype=PIECE)
    text = []
    for first in range(0, count, AT_ONCE):
        part = table[: count - first]
        for column, each in enumerate(pieces):
            part[:, column] = each[first : first + AT_ONCE] if isinstance(each, np.ndarray) else each
        text.append(written(part))
    return b"".join(text)


def written(pieces: np.ndarray) -> bytes:
    """The text of pieces, shape (n, k)."""
    return pieces.tobytes().translate(None, b"\0")


def _whole(size: np.ndarray) -> Cell:
    """Numbers of any length, the highest five digits first."""
    short, padded = tables()
    high, low = _parted(size, FIVE)
    longer = high > 0
    if not longer.any():
        return [short[low]]
    return [*only(_whole(high), longer), np.where(longer, padded[low], short[low])]


def _parted(size: np.ndarray, by: int) -> tuple[np.ndarray, np.ndarray]:
    """Quotient and remainder; numpy's own divmod takes three times as long."""
    quotient = size // by
    return quotient, size - quotient * by
