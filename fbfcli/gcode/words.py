"""Segments to G1 lines, as arrays of characters: no Python loop per line.

Every word is an integer of 1e-5 of the file's unit (five decimals), so sums and differences of words are exact.
"""

from __future__ import annotations

import numpy as np

SCALE = 100_000  # words per mm or inch: five decimals
DECIMALS = 5
WHOLE_DIGITS = 7
WIDTH = 2 + 1 + WHOLE_DIGITS + 1 + DECIMALS  # " X", sign, whole part, point, decimals
_TENS = [10**k for k in range(WHOLE_DIGITS - 1, -1, -1)]


def to_words(values: np.ndarray) -> np.ndarray:
    """Nearest word of each value, int64."""
    return np.rint(values * SCALE).astype(np.int64)


def feed_words(feed: np.ndarray) -> np.ndarray:
    """Words of feedrates [unit/min] with at least six significant digits, never zero."""
    coarse = np.rint(feed * 100).astype(np.int64) * (SCALE // 100)
    return np.maximum(np.where(feed >= 1000.0, coarse, to_words(feed)), 1)


def _field(letter: str, words: np.ndarray, chars: np.ndarray, keep: np.ndarray) -> None:
    """Write one column of words into the (n, WIDTH) views `chars` and `keep`."""
    size = np.abs(words)
    whole = (size // SCALE).astype(np.int32)
    part = (size - whole.astype(np.int64) * SCALE).astype(np.int32)
    chars[:, 0], chars[:, 1], chars[:, 2] = 32, ord(letter), 45  # " ", letter, "-"
    keep[:, :2] = True
    keep[:, 2] = words < 0
    for column, ten in enumerate(_TENS, 3):
        digit = whole // ten
        chars[:, column] = (digit % 10) + 48
        keep[:, column] = digit > 0
    point = 3 + WHOLE_DIGITS
    keep[:, point - 1] = True  # 0.5, never .5
    chars[:, point] = 46
    keep[:, point] = part > 0
    rest = part
    for column, ten in enumerate(_TENS[-DECIMALS:], point + 1):
        keep[:, column] = rest > 0
        digit = rest // ten
        chars[:, column] = digit + 48
        rest = rest - digit * ten


def g1_lines(columns: list[tuple[str, np.ndarray, np.ndarray | None]]) -> tuple[bytes, np.ndarray]:
    """G1 lines of n segments.

    columns : list of (letter, words, present)   words: int64, shape (n,); present: bool, shape (n,), or None for all

    Returns the text and the offset at which each line begins, shape (n + 1,).
    """
    n = len(columns[0][1])
    chars = np.empty((n, 2 + WIDTH * len(columns) + 1), dtype=np.uint8)
    keep = np.empty(chars.shape, dtype=bool)
    chars[:, 0], chars[:, 1], chars[:, -1] = 71, 49, 10  # "G1", newline
    keep[:, :2] = True
    keep[:, -1] = True
    for i, (letter, words, present) in enumerate(columns):
        part = slice(2 + i * WIDTH, 2 + (i + 1) * WIDTH)
        _field(letter, words, chars[:, part], keep[:, part])
        if present is not None:
            keep[:, part] &= present[:, None]
    offsets = np.concatenate([[0], np.cumsum(np.count_nonzero(keep, axis=1))])
    return chars[keep].tobytes(), offsets
