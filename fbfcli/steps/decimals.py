"""Rows of numbers as text, by array code: four digits at a time from a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_FOUR = np.frombuffer("".join(f"{i:04d}" for i in range(10_000)).encode(), dtype=np.uint8).reshape(-1, 4)
_POWERS = 10 ** np.arange(1, 19, dtype=np.int64)


@dataclass(frozen=True)
class Column:
    """One cell of each row: ASCII codes, shape (n, width), and which of them are written."""

    cells: np.ndarray
    kept: np.ndarray


def fixed(text: bytes, rows: int) -> Column:
    """The same text in every row."""
    cells = np.broadcast_to(np.frombuffer(text, dtype=np.uint8), (rows, len(text)))
    return Column(cells, np.broadcast_to(np.True_, cells.shape))


def chosen(texts: Sequence[bytes], which: np.ndarray) -> Column:
    """One of several texts in each row, `which` of shape (n,)."""
    width = max(map(len, texts))
    cells = np.frombuffer(b"".join(text.ljust(width, b"\0") for text in texts), dtype=np.uint8).reshape(-1, width)
    kept = np.arange(width) < np.array([len(text) for text in texts])[:, None]
    return Column(cells[which], kept[which])


def decimal(value: np.ndarray, places: int = 0) -> Column:
    """Integers in units of the last of `places` decimals, shape (n,): -1234 at 2 places is -12.34."""
    size = np.abs(value)
    needed = np.maximum(np.searchsorted(_POWERS, size, side="right") + 1, places + 1)
    fours = -(-int(needed.max(initial=1)) // 4)
    digits = np.empty((len(value), fours, 4), dtype=np.uint8)
    for i in range(fours - 1, 0, -1):
        size, four = np.divmod(size, 10_000)
        digits[:, i] = _FOUR[four]
    digits[:, 0] = _FOUR[size]
    width = 4 * fours
    cells = np.empty((len(value), width + 1 + bool(places)), dtype=np.uint8)
    kept = np.empty(cells.shape, dtype=bool)
    whole = width - places
    cells[:, 0], kept[:, 0] = ord("-"), value < 0
    cells[:, 1 : whole + 1] = digits.reshape(-1, width)[:, :whole]
    kept[:, 1 : whole + 1] = np.arange(width, places, -1) <= needed[:, None]
    if places:
        cells[:, whole + 1] = ord(".")
        cells[:, whole + 2 :] = digits.reshape(-1, width)[:, whole:]
        kept[:, whole + 1 :] = True
    return Column(cells, kept)


def only(column: Column, where: np.ndarray) -> Column:
    """A column that is written in some rows, bool, shape (n,)."""
    return Column(column.cells, column.kept & where[:, None])


def rows(*columns: Column) -> bytes:
    """The text of all rows, cell after cell."""
    cells = np.concatenate([column.cells for column in columns], axis=1)
    return cells[np.concatenate([column.kept for column in columns], axis=1)].tobytes()
