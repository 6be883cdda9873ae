"""Nodes and kept lines to G-code again.

A node's word is the nearest five-decimal number in the coordinates, units and mode (absolute or relative) of its place
in the file. Relative words are differences of absolute ones, so rounding never adds up.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from fbfcli.gcode.words import SCALE, feed_words, g1_lines, to_words
from fbfcli.units import MM_PER_INCH, S_PER_MIN

NUDGES = 16  # a nudged node may meet its other neighbour


@dataclass(frozen=True)
class Modes:
    """Modal state at n places of a file.

    xy_relative, e_relative, inch : ndarray of bool, shape (n,)
    offset       : ndarray, shape (n, 4)   machine coordinate minus the file's, X Y Z E [mm]
    speed_factor : ndarray, shape (n,)     M220
    """

    xy_relative: np.ndarray
    e_relative: np.ndarray
    inch: np.ndarray
    offset: np.ndarray
    speed_factor: np.ndarray

    def __getitem__(self, where: np.ndarray) -> Modes:
        return Modes(*(getattr(self, f.name)[where] for f in fields(self)))

    def then(self, later: Modes) -> Modes:
        """These places and later ones."""
        return Modes(*(np.concatenate([getattr(self, f.name), getattr(later, f.name)]) for f in fields(self)))


def power_on_modes() -> Modes:
    """One place, before the first line."""
    no, one = np.zeros(1, dtype=bool), np.ones(1)
    return Modes(no, no, no, np.zeros((1, 4)), one)


@dataclass(frozen=True)
class Words:
    """Words of n segments, and where they lead once rounded.

    begin, end : ndarray of int64, shape (n, 4)   absolute words of both ends of each segment, in its own modes
    unit       : ndarray, shape (n,)              mm per unit of the file
    real       : ndarray of bool, shape (n,)      False for a gap between stretches, which is not written
    """

    begin: np.ndarray
    end: np.ndarray
    unit: np.ndarray
    real: np.ndarray

    @property
    def step(self) -> np.ndarray:
        """Relative words, shape (n, 4)."""
        return self.end - self.begin

    @property
    def delta(self) -> np.ndarray:
        """Displacements that a firmware makes of the words [mm], shape (n, 4)."""
        return self.step * (self.unit[:, None] / SCALE)


def words_of(nodes: np.ndarray, modes: Modes, real: np.ndarray, movable: np.ndarray) -> Words:
    """Rounded words of the nodes' positions.

    nodes   : ndarray, shape (n + 1, 4)          machine coordinates [mm]
    modes   : Modes of n segments
    movable : ndarray of bool, shape (n + 1,)    nodes that may move by a unit of the last decimal

    No segment is left without length: a firmware drops those, and their time with them.
    """
    unit = np.where(modes.inch, MM_PER_INCH, 1.0)
    begin = to_words((nodes[:-1] - modes.offset) / unit[:, None])
    end = to_words((nodes[1:] - modes.offset) / unit[:, None])
    for attempt in range(NUDGES):
        same = real & (begin[:, :3] == end[:, :3]).all(axis=1)
        if not same.any():
            break
        nudge = _nudges(same, movable) * (-2 if attempt % 2 else 1)
        begin[:, 0] += nudge[:-1]
        end[:, 0] += nudge[1:]
    return Words(begin, end, unit, real)


def _nudges(same: np.ndarray, movable: np.ndarray) -> np.ndarray:
    """Units to add to X of each node so that no two neighbours in a row of equal nodes stay equal, shape (n + 1,).

    same : ndarray of bool, shape (n,)   segments without length
    """
    nudge = np.zeros(len(movable), dtype=np.int64)
    stuck = np.flatnonzero(same)
    if not len(stuck):
        return nudge
    new = np.diff(stuck, prepend=-2) > 1
    row = np.cumsum(new) - 1
    place = stuck - stuck[new][row]  # 0, 1, ... within a row of stuck segments
    left = np.append(np.flatnonzero(new)[1:], len(stuck))[row] - np.arange(
        len(stuck)
    )  # segments left, this one included
    nudge[stuck + 1] = np.where(left == 1, 0, np.where((left == 2) & (place % 2 == 1), 2, (place + 1) % 2))
    alone = stuck[(left == 1) & (place == 0)]
    end = np.where(movable[alone + 1], alone + 1, alone)
    nudge[end] += 1
    return np.where(movable, nudge, 0)


def feed_of(speed: np.ndarray, unit: np.ndarray, speed_factor: np.ndarray) -> np.ndarray:
    """F words [1e-5 unit/min] for speeds [mm/s], what M220 will multiply divided out."""
    return feed_words(speed * (S_PER_MIN / (unit * speed_factor)))


def speed_of(feed: np.ndarray, unit: np.ndarray, speed_factor: np.ndarray) -> np.ndarray:
    """Speeds [mm/s] that F words stand for."""
    return feed * (unit * speed_factor / (S_PER_MIN * SCALE))


def segment_lines(words: Words, modes: Modes, feed: np.ndarray) -> tuple[bytes, np.ndarray]:
    """G1 lines of the real segments and, for every segment, the offset where its line begins, shape (n + 1,)."""
    here = np.flatnonzero(words.real)
    end, step = words.end[here], words.step[here]
    xyz_relative, e_relative = modes.xy_relative[here], modes.e_relative[here]
    x, y, z = (np.where(xyz_relative, step[:, i], end[:, i]) for i in range(3))
    text, offsets = g1_lines(
        [
            ("X", x, None),
            ("Y", y, None),
            ("Z", z, step[:, 2] != 0),
            ("E", np.where(e_relative, step[:, 3], end[:, 3]), step[:, 3] != 0),
            ("F", feed[here], None),
        ]
    )
    return text, offsets[np.concatenate([[0], np.cumsum(words.real)])]
