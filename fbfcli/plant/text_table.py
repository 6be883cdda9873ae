"""A table of numbers in text: header, comments and footer found, bad rows named by their line.

Commas, semicolons (then with decimal commas), tabs or blanks part the cells.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from fbfcli.errors import RecordingError

MOST_FOOTERS = 20  # lines after the last number; more of them is another kind of file
SEPARATORS = (",", ";", "\t", None)  # None: blanks


@dataclass(frozen=True)
class TextTable:
    """Numbers with the words around them.

    name     : the file, for messages
    header   : names of the columns as written, or ()
    values   : ndarray, shape (n, k)
    line     : ndarray of int, shape (n,)   of each row in the file, from 1
    comments : lines that begin with #, without it
    footer   : (line, text) of words after the last row
    notes    : rows that were left out
    """

    name: str
    header: tuple[str, ...]
    values: np.ndarray
    line: np.ndarray
    comments: tuple[str, ...] = ()
    footer: tuple[tuple[int, str], ...] = ()
    notes: tuple[str, ...] = ()

    def error(self, why: str, row: int | None = None, remedy: str = "") -> RecordingError:
        """What is wrong with a row (its line is told), or with the table."""
        return RecordingError(why, file=self.name, line=None if row is None else int(self.line[row]), remedy=remedy)


def text_of(data: bytes, name: str) -> str:
    """The file as text. RecordingError where it is none."""
    wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    if not wide and b"\0" in data[:4096]:
        raise RecordingError("is not text", file=name, remedy="export the recording as CSV")
    text = data.decode("utf-16" if wide else "utf-8-sig", errors="replace")
    if not text.strip():
        raise RecordingError("is empty", file=name, remedy="record again; the sensor sent nothing")
    return text


def read_table(text: str, name: str) -> TextTable:
    """The table of a text. Raises RecordingError with the line of the first row that cannot be read."""
    every = [(number, row.strip()) for number, row in enumerate(text.splitlines(), 1)]
    comments = tuple(row.lstrip("# \t") for _, row in every if row.startswith("#"))
    rows = [(number, row) for number, row in every if row and not row.startswith("#")]
    head = next((i for i, (_, row) in enumerate(rows[:MOST_FOOTERS]) if numbers(row)), None)
    if head is None:
        number, words = next(iter(rows[1:] or rows or every))
        raise RecordingError("no numbers in it", file=name, line=number, text=words,
                             remedy="the capture failed; record again")  # fmt: skip
    body, footer, notes = _without_footer(rows[head:], name)
    separator = separator_of(body[0][1])
    values = _values(body, separator, name)
    titles = [cells(row, separator_of(row)) for row in (*comments, *(row for _, row in rows[:head]))]
    header = next((row for row in reversed(titles) if len(row) == values.shape[1]), ())
    if head and len(titles[-1]) != values.shape[1]:
        raise RecordingError(f"{len(titles[-1])} names for {values.shape[1]} columns", file=name,
                             line=rows[head - 1][0], remedy="give each column its name")  # fmt: skip
    return TextTable(name, header, values, np.array([number for number, _ in body]), comments, footer, notes)


def separator_of(row: str) -> str | None:
    """What parts the cells of a row."""
    if ";" in row:
        return ";"
    return next((s for s in SEPARATORS if s is None or s in row), None)


def cells(row: str, separator: str | None) -> tuple[str, ...]:
    """Cells of a row, blanks and quotes taken off."""
    return tuple(cell.strip().strip("\"'") for cell in row.split(separator))


def numbers(row: str) -> int:
    """How many numbers a row consists of; 0 where a cell is none."""
    separator = separator_of(row)
    parts = cells(row.replace(",", ".") if separator == ";" else row, separator)
    return len(parts) if all(re.fullmatch(_NUMBER, part) for part in parts) else 0


_NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|NaN|Inf|NAN|INF)"


def _without_footer(
    rows: list[tuple[int, str]], name: str
) -> tuple[list[tuple[int, str]], tuple[tuple[int, str], ...], tuple[str, ...]]:
    """The rows of numbers, the words after them, and what is told of a last row that was cut off."""
    width, end = numbers(rows[0][1]), len(rows)
    while end > 1 and len(rows) - end < MOST_FOOTERS and not numbers(rows[end - 1][1]):
        end -= 1
    notes: tuple[str, ...] = ()
    if end > 1 and numbers(rows[end - 1][1]) != width:
        end -= 1
        notes = (f"line {rows[end][0]}: the last row is cut off and left out",)
    return rows[:end], tuple(rows[end:] if not notes else rows[end + 1 :]), notes


def _values(rows: list[tuple[int, str]], separator: str | None, name: str) -> np.ndarray:
    """All cells as numbers, shape (n, k)."""
    lines = [row for _, row in rows]
    if separator == ";":
        lines = [row.replace(",", ".") for row in lines]
    try:
        values = np.loadtxt(lines, delimiter=separator, comments=None, ndmin=2)
    except ValueError:
        width = numbers(lines[0])
        row, text = next((r for r in rows if numbers(r[1]) != width), rows[0])
        raise RecordingError(f"{width} numbers are expected here", file=name, line=row, text=text,
                             remedy="mend the line or cut it out") from None  # fmt: skip
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        number, text = rows[bad[0]]
        raise RecordingError("a value is not finite", file=name, line=number, text=text, remedy="cut the line out")
    return values
