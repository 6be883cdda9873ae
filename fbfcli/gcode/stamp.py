"""The stamp of a compensated file, and the lines of a print that tell its time.

Slicers and hosts read time from M73 and from comments. The new time is known only at the end: such lines are written
padded with blanks, and filled in when the print has been planned.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain

STAMP = b"; fbf "
HEAD_BYTES = 4096  # the stamp stands on the second line
PADDING = 12  # blanks that a longer time may take

_CLOCK = rb"(?:\d+[dhms]\s*)+"
_CLOCK_LINES = re.compile(
    rb"(estimated (?:first layer )?printing time[^=]*=\s*|total estimated time:\s*|model printing time:\s*)("
    + _CLOCK
    + rb")"
)
_SECONDS = re.compile(rb"^(;\s*(?:TIME|Print Time|PRINT\.TIME):\s*)(\d+(?:\.\d+)?)\s*$", re.IGNORECASE)
_ELAPSED = re.compile(rb"^(;TIME_ELAPSED:)(\d+(?:\.\d+)?)\s*$")
_M73 = re.compile(rb"^\s*M73\b", re.IGNORECASE)
_PERCENT = re.compile(rb"([PQ])\s*\d+(?:\.\d+)?", re.IGNORECASE)
_REMAINING = re.compile(rb"([RS])\s*\d+(?:\.\d+)?", re.IGNORECASE)


def stamp(version: str, settings: str) -> bytes:
    """The line that says what was done, without its newline."""
    return STAMP + f"{version}: vibration compensated, {settings}".encode()


def is_stamped(head: bytes) -> bool:
    """Whether the beginning of a file carries a stamp."""
    return any(line.startswith(STAMP) for line in head[:HEAD_BYTES].splitlines()[:16])


def looked_into(texts: Iterator[bytes]) -> tuple[bool, Iterator[bytes]]:
    """Whether the first of a file's texts carries a stamp, and all of them again."""
    first = next(texts, b"")
    return is_stamped(first), chain([first] if first else [], texts)


@dataclass(frozen=True)
class TimeLine:
    """A line that tells time; `write(elapsed, total)` gives its new text, as long as `room` bytes at most."""

    room: int
    write: Callable[[float, float], bytes]

    def padded(self, elapsed: float, total: float) -> bytes:
        """The new text, blanks up to `room`; a text that does not fit is cut at the right."""
        return self.write(elapsed, total).ljust(self.room)[: self.room]


def time_line(text: bytes) -> TimeLine | None:
    """What to do with a line (without its newline) that tells the time of a print; None for any other."""
    room = len(text) + PADDING
    if _M73.match(text):
        return TimeLine(room, lambda elapsed, total: _m73(text, elapsed, total))
    if found := _ELAPSED.match(text):
        prefix = found[1]
        return TimeLine(room, lambda elapsed, total: prefix + b"%.6f" % elapsed)
    if found := _SECONDS.match(text):
        label = found[1]
        return TimeLine(room, lambda elapsed, total: label + b"%d" % round(total))
    if _CLOCK_LINES.search(text):
        if b"silent" in text or b"first layer" in text:
            return None  # of another mode, or of a part that is not tallied
        return TimeLine(room + PADDING, lambda elapsed, total: _CLOCK_LINES.sub(lambda m: m[1] + _clock(total), text))
    return None


def _m73(text: bytes, elapsed: float, total: float) -> bytes:
    """P and Q percent done, R and S minutes left; other words (L layer, C) stay."""
    code, mark, comment = text.partition(b";")
    left = max(total - elapsed, 0.0)
    share = elapsed / total if total > 0 else 1.0
    code = _PERCENT.sub(lambda m: m[1] + b"%d" % int(100 * share + 1e-9), code)
    code = _REMAINING.sub(lambda m: m[1] + b"%d" % round(left / 60), code)
    return code + mark + comment


def _clock(seconds: float) -> bytes:
    """1d 2h 3m 4s, as PrusaSlicer writes it."""
    left = round(seconds)
    parts: list[str] = []
    for letter, size in (("d", 86400), ("h", 3600), ("m", 60)):
        if left >= size or parts:
            parts.append(f"{left // size}{letter}")
            left %= size
    return " ".join([*parts, f"{left}s"]).encode()
