"""Segments to G1 lines, as arrays of characters: no Python loop per line.

Every word is an integer of 1e-5 of the file's unit (five decimals), so sums and differences of words are exact. A word
is written as three pieces of eight bytes, looked up in tables; bytes that are not needed are zero, and taken out of all
lines at once:  " X-" and the digits above 1e5 | five digits before the point | the point and five decimals.
"""

from __future__ import annotations

from functools import cache

import numpy as np

SCALE = 100_000  # words per mm or inch: five decimals
PIECE = np.dtype("<u8")  # eight bytes, the first one lowest


def to_words(values: np.ndarray) -> np.ndarray:
    """Nearest word of each value, int64."""
    return np.rint(values * SCALE).astype(np.int64)


def feed_words(feed: np.ndarray) -> np.ndarray:
    """Words of feedrates [unit/min] with at least six significant digits, never zero."""
    coarse = np.rint(feed * 100).astype(np.int64) * (SCALE // 100)
    return np.maximum(np.where(feed >= 1000.0, coarse, to_words(feed)), 1)


@cache
def _tables() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eight bytes for each number below 1e5: as it is written, with leading zeros, as decimals behind a point."""
    number = np.arange(SCALE)
    digits = (number[:, None] // 10 ** np.arange(4, -1, -1) % 10 + ord("0")).astype(np.uint8)
    padded, short, decimals = (np.zeros((SCALE, 8), dtype=np.uint8) for _ in range(3))
    padded[:, 3:] = short[:, 3:] = digits
    for column in range(4):  # leading zeros, but for the last
        short[number < 10 ** (4 - column), 3 + column] = 0
    decimals[:, 0] = ord(".")
    decimals[:, 1:6] = digits
    for column in range(5):  # trailing zeros, and the point behind which all are
        decimals[number % 10 ** (5 - column) == 0, 1 + column] = 0
    decimals[0] = 0
    return tuple(table.view(PIECE).ravel() for table in (short, padded, decimals))  # type: ignore[return-value]


def _field(letter: str, words: np.ndarray, pieces: np.ndarray) -> None:
    """Write one column of words into the (n, 3) view `pieces`."""
    short, padded, decimals = _tables()
    size = np.abs(words)
    whole = size // SCALE
    np.take(decimals, size - whole * SCALE, out=pieces[:, 2])
    head, minus = (np.frombuffer(text.ljust(8, b"\0"), PIECE)[0] for text in (b" " + letter.encode(), b"\0\0-"))
    pieces[:, 0] = head
    pieces[:, 0] += np.where(words < 0, minus, np.uint64(0))
    long = np.flatnonzero(whole >= SCALE)
    np.take(short, whole % SCALE if len(long) else whole, out=pieces[:, 1])
    pieces[long, 1] = padded[whole[long] % SCALE]
    pieces[long, 0] += short[whole[long] // SCALE]


def g1_lines(columns: list[tuple[str, np.ndarray, np.ndarray | None]]) -> tuple[bytes, np.ndarray]:
    """G1 lines of n segments.

    columns : list of (letter, words, present)   words: int64 below 1e15, shape (n,); present: bool, shape (n,), or None
              for all

    Returns the text and the offset at which each line begins, shape (n + 1,).
    """
    n = len(columns[0][1])
    pieces = np.empty((n, 1 + 3 * len(columns) + 1), dtype=PIECE)
    pieces[:, 0], pieces[:, -1] = (np.frombuffer(text.ljust(8, b"\0"), PIECE)[0] for text in (b"G1", b"\n"))
    for i, (letter, words, present) in enumerate(columns):
        part = pieces[:, 1 + 3 * i : 4 + 3 * i]
        _field(letter, words, part)
        if present is not None:
            part[~present] = 0
    text = pieces.tobytes().translate(None, b"\0")
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")) + 1
    return text, np.concatenate([[0], ends])
