"""Lines waiting to be written: their text, what they are, and the modal state after each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from fbfcli.gcode.interpret import Block
from fbfcli.gcode.scan import MODAL
from fbfcli.gcode.write import Modes


@dataclass(frozen=True)
class Listing:
    """n lines of a file, in order.

    text        : bytes                          they stand in it, at
    begin, end  : ndarray of int, shape (n,)
    number      : ndarray of int, shape (n,)     in the file, from 0, increasing
    kind        : ndarray of uint8, shape (n,)   dialects.Kind
    wait        : ndarray, shape (n,)            dwell [s]
    known       : ndarray of bool, shape (n,)    X, Y, Z are known after it
    has_feed, has_command : ndarray of bool      a motion line that has its own F, G word
    feed        : ndarray, shape (n,)            modal F after it, as written
    motion      : ndarray of int, shape (n,)     modal G0 to G3 after it
    state       : ndarray of int, shape (n,)     limits in force after it, index into the moves' table
    e_file      : ndarray, shape (n,)            the file's own E after it [mm]
    xy_relative, e_relative, inch : ndarray of bool, shape (n,)
    offset      : ndarray, shape (n, 3)          machine minus file coordinate, X Y Z [mm]
    speed_factor : ndarray, shape (n,)
    """

    text: bytes
    begin: np.ndarray
    end: np.ndarray
    number: np.ndarray
    kind: np.ndarray
    wait: np.ndarray
    known: np.ndarray
    has_feed: np.ndarray
    has_command: np.ndarray
    feed: np.ndarray
    motion: np.ndarray
    state: np.ndarray
    e_file: np.ndarray
    xy_relative: np.ndarray
    e_relative: np.ndarray
    inch: np.ndarray
    offset: np.ndarray
    speed_factor: np.ndarray

    def __len__(self) -> int:
        return len(self.kind)

    def raw(self, i: int) -> bytes:
        """Row i as it stands in the file, with its line end."""
        return self.text[self.begin[i] : self.end[i]]

    def modes(self, e_machine: np.ndarray) -> Modes:
        """Modal state after each line, given the machine's E there (n,) [mm]."""
        offset = np.column_stack([self.offset, e_machine - self.e_file])
        return Modes(self.xy_relative, self.e_relative, self.inch, offset, self.speed_factor)

    def __getitem__(self, rows: slice | np.ndarray) -> Listing:
        return Listing(self.text, **{f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "text"})

    def split(self, number: int) -> tuple[Listing, Listing]:
        """The lines before line `number` of the file, and the rest."""
        cut = int(np.searchsorted(self.number, number))
        return self[:cut], self[cut:]


def listing(block: Block) -> Listing:
    """The lines of an interpreted block."""
    lines = block.lines
    return Listing(
        text=lines.text,
        begin=lines.begin,
        end=lines.end,
        number=np.arange(lines.first, lines.first + len(lines)),
        kind=block.kind,
        wait=block.wait,
        known=block.known,
        has_feed=~np.isnan(lines.words["F"]),
        has_command=lines.code != MODAL,
        feed=block.feed,
        motion=block.motion_mode,
        state=block.state,
        e_file=block.e_logical,
        xy_relative=block.xy_relative,
        e_relative=block.e_relative,
        inch=block.inch,
        offset=block.offset,
        speed_factor=block.speed_factor,
    )


def join(parts: Sequence[Listing]) -> Listing:
    """Listings one after the other as one, with no more text than they need."""
    parts = [part for part in parts if len(part)] or list(parts[:1])
    if len(parts) == 1:
        return parts[0]
    texts = [part.text[part.begin[0] : part.end[-1]] for part in parts]
    place = np.cumsum([0] + [len(text) for text in texts[:-1]]) - [part.begin[0] for part in parts]
    rows = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Listing) if f.name != "text"
    }
    move = np.repeat(place, [len(part) for part in parts])
    return Listing(b"".join(texts), **{**rows, "begin": rows["begin"] + move, "end": rows["end"] + move})
