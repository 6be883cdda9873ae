"""Segments to G1 lines, as arrays of characters: no Python loop per line.

Every word is an integer of 1e-5 of the file's unit (five decimals), so sums and differences of words are exact. A word
is three pieces of eight bytes:  " X-" and the digits above 1e5 | five digits before the point | point and decimals.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from fbfcli.digits import FIVE, PIECE, piece, tables, written

SCALE = FIVE  # words per mm or inch: five decimals


def to_words(values: np.ndarray) -> np.ndarray:
    """Nearest word of each value, int64."""
    return np.rint(values * SCALE).astype(np.int64)


def feed_words(feed: np.ndarray) -> np.ndarray:
    """Words of feedrates [unit/min] with at least six significant digits, never zero."""
    coarse = np.rint(feed * 100).astype(np.int64) * (SCALE // 100)
    return np.maximum(np.where(feed >= 1000.0, coarse, to_words(feed)), 1)


@cache
def _decimals() -> np.ndarray:
    """A piece for each number below 1e5: as decimals behind a point, without zeros at the end."""
    number = np.arange(SCALE)
    pieces = np.zeros((SCALE, 8), dtype=np.uint8)
    pieces[:, 0] = ord(".")
    pieces[:, 1:6] = tables()[1].view(np.uint8).reshape(-1, 8)[:, 3:]
    for column in range(5):  # and the point behind which all are
        pieces[number % 10 ** (5 - column) == 0, 1 + column] = 0
    pieces[0] = 0
    return pieces.view(PIECE).ravel()


def _field(letter: str, words: np.ndarray, pieces: np.ndarray) -> None:
    """Write one column of words into the (n, 3) view `pieces`."""
    short, padded = tables()
    size = np.abs(words)
    whole = size // SCALE
    np.take(_decimals(), size - whole * SCALE, out=pieces[:, 2])
    pieces[:, 0] = piece(b" " + letter.encode())
    pieces[:, 0] += np.where(words < 0, piece(b"\0\0-"), np.uint64(0))
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
    pieces[:, 0], pieces[:, -1] = piece(b"G1"), piece(b"\n")
    for i, (letter, words, present) in enumerate(columns):
        part = pieces[:, 1 + 3 * i : 4 + 3 * i]
        _field(letter, words, part)
        if present is not None:
            part[~present] = 0
    text = written(pieces)
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n")) + 1
    return text, np.concatenate([[0], ends])
