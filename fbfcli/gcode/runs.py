"""Runs: where limits are raised and put back, and the text of every line that stays.

A run lasts from the first compensated stretch after a barrier to the next barrier; a move of X or Y that stays as it
was written is one too. Inside a run the planner's limits are raised, so lines that change limits wait as comments, and
motion lines that stay (of Z or E) say their F anew.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing
from fbfcli.gcode.motion import DEFAULT_FEED
from fbfcli.gcode.placement import Places
from fbfcli.gcode.raised import raise_lines, restore_lines
from fbfcli.gcode.words import SCALE
from fbfcli.printer import Limits

DEFERRED = b"; fbf: "
_NUMBER = re.compile(rb"^\s*[Nn]\d+\s*")
_CHECKSUM = re.compile(rb"\s*\*\d+[ \t]*(?=\r?\n?$|;)")
_MAY_BE_NUMBERED = np.isin(np.arange(256), list(b"Nn \t"))
_E_NUMBER = re.compile(rb"[Ee]\s*[-+.\d]*")
_DECLARES = re.compile(rb"^\s*[Gg]0*92(?![.\d])")


@dataclass(frozen=True)
class Raised:
    """Whether limits are raised around the lines of a part.

    line  : ndarray of bool, shape (k,)   before each kept line
    begin : ndarray of bool, shape (s,)   they are raised right before this stretch
    after : bool                          at the end of the part
    """

    line: np.ndarray
    begin: np.ndarray
    after: bool


def raised_where(number: np.ndarray, barrier: np.ndarray, starts: np.ndarray, before: bool) -> Raised:
    """Follow the runs through a part.

    number  : ndarray of int, shape (k,)    kept lines, increasing
    barrier : ndarray of int                lines that end a run, increasing
    starts  : ndarray of int, shape (s,)    line that begins each stretch
    before  : limits are raised when the part begins
    """
    run = np.searchsorted(barrier, starts)
    begin = np.diff(run, prepend=0 if before else -1) != 0
    stretch = np.searchsorted(starts, number) - 1  # the last one begun before each line
    run_of_line = np.searchsorted(barrier, number)
    run_of_stretch = np.append(run, 0 if before else -1)[stretch]
    last_run = run[-1] if len(run) else (0 if before else -1)
    return Raised(run_of_stretch == run_of_line, begin, bool(last_run == len(barrier)))


def raising(firmware: str, limits: Limits) -> bytes:
    """Text before the first stretch of a run."""
    return _text(raise_lines(firmware, limits))


def restoring(firmware: str, limits: Limits, base: Limits, feed: float) -> bytes:
    """Text after a run that raised `base`: the file's limits, and its F."""
    return _text(restore_lines(firmware, limits, base)) + feed_line(feed)


def feed_line(feed: float) -> bytes:
    """The F that the file has in force, as its next motion line expects it."""
    feed = DEFAULT_FEED if np.isnan(feed) else feed
    return f"G1 F{feed:.5f}".rstrip("0").rstrip(".").encode() + b"\n"


def _text(lines: list[str]) -> bytes:
    return "".join(line + "\n" for line in lines).encode()


def is_special(places: Places, raised: np.ndarray) -> np.ndarray:
    """Lines whose text `kept_text` may change, bool, shape (k,).

    raised : ndarray of bool, shape (k,)   limits are raised before the line
    """
    lines = places.lines
    byte = np.frombuffer(lines.text, dtype=np.uint8)
    if not len(byte):
        return np.zeros(len(lines), dtype=bool)
    numbered = _MAY_BE_NUMBERED[byte[lines.begin]]
    unterminated = byte[lines.end - 1] != ord("\n")
    waits = lines.kind == int(Kind.LIMITS)
    return numbered | unterminated | (raised & (waits | places.barrier | places.moves))


def joints(lines: Listing, special: np.ndarray) -> np.ndarray:
    """Where a new piece of text begins: at special lines, after them, where lines were left out, bool, shape (k,)."""
    new = special.copy()
    new[1:] |= special[:-1] | (lines.begin[1:] != lines.end[:-1])
    new[:1] = True
    return new


def kept_text(places: Places, i: int, raised: bool, restore: bytes, e_word: int | None) -> bytes:
    """Line i of the places, as it is written.

    raised : limits are raised before it
    restore : what puts them back, for a barrier
    e_word  : E that a G92 inside a stretch declares [1e-5 of the file's unit], None elsewhere
    """
    lines = places.lines
    raw = lines.raw(i)
    if not raw.endswith(b"\n"):
        raw += b"\n"  # Klipper's batch reader drops an unterminated last line
    if raw[:1] in b"Nn \t" and _NUMBER.match(raw):
        raw = _CHECKSUM.sub(b"", _NUMBER.sub(b"", raw), count=1)
    kind = lines.kind[i]
    if kind == Kind.MODE and e_word is not None and _DECLARES.match(raw):
        return _E_NUMBER.sub(f"E{e_word / SCALE:.5f}".encode(), raw, count=1)
    if not raised:
        return raw
    if kind == Kind.LIMITS:
        return DEFERRED + raw
    if places.moves[i] and not lines.has_command[i] and lines.motion[i] > 1:
        raw = b"G%d " % lines.motion[i] + raw
    if places.barrier[i]:
        return restore + raw
    if places.moves[i] and not lines.has_feed[i]:
        return feed_line(lines.feed[i]) + raw
    return raw
