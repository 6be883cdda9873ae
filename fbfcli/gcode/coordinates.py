"""The file's coordinates and the machine's, line by line, as array code.

L_i, the logical coordinate after line i, is the last absolute word (or G92, or home) plus the relative moves since:

    L_i = v_b + S_i - S_b        b = last line with an absolute value, S = cumulative sum of relative words

and the machine's coordinate is M = L + offset, where the offset changes at G92 and G28 only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.modal import Modal
from fbfcli.gcode.scan import Lines
from fbfcli.gcode.state import State
from fbfcli.units import MM_PER_INCH

AXES = "XYZE"


@dataclass(frozen=True)
class Track:
    """Coordinates around n lines; entry i is before line i, entry n after the last.

    logical : 4 ndarrays, shape (n + 1,)   X, Y, Z, E of the file [mm]
    offset  : 4 ndarrays, shape (n + 1,)   machine - logical [mm]
    step    : 4 ndarrays, shape (n,)       displacement each motion line asks for [mm]
    known   : 2 ndarrays of bool, shape (n + 1,)   X and Y are where the file says
    """

    logical: tuple[np.ndarray, ...]
    offset: tuple[np.ndarray, ...]
    step: tuple[np.ndarray, ...]
    known: tuple[np.ndarray, ...]


def track(lines: Lines, modal: Modal, state: State) -> Track:
    """Coordinates around every line."""
    inches = bool(modal.inch.any())
    logical, offset, step, known = [], [], [], []
    for axis, name in enumerate(AXES):
        word = lines.words[name]
        if inches:
            word = np.where(modal.inch, MM_PER_INCH * word, word)
        relative = modal.e_relative if name == "E" else modal.xy_relative
        fixed = {line: value for line, k, value in modal.declared if k == axis}
        home = [line for line, k in modal.homed if k == axis]
        fixed.update((line, state.home[axis]) for line in home)
        at, moved = _logical(word, relative, fixed, state.logical[axis])
        sure = np.ones(len(word) + 1, bool)
        if axis < 2:
            sure = _known(word, relative, modal, axis, state.known[axis])
            known.append(sure)
        logical.append(at)
        step.append(moved)
        offset.append(_offset(at, sure, fixed, set(home), state.offset[axis]))
    return Track(tuple(logical), tuple(offset), tuple(step), tuple(known))


def last_true(mask: np.ndarray) -> np.ndarray:
    """Index of the last True at or before each entry, 0 where there is none."""
    return np.maximum.accumulate(np.where(mask, np.arange(len(mask)), 0))


def _logical(
    word: np.ndarray, relative: np.ndarray, fixed: dict[int, float], start: float
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates before and after every line, and the displacement of every line."""
    value = np.concatenate(([start], word))
    given = value == value
    shift = given[1:] & relative
    at = np.array(list(fixed), np.intp)
    value[at + 1] = list(fixed.values())
    given[at + 1] = True
    if not shift.any():
        logical = value[last_true(given)]
        step = np.diff(logical)
    else:
        given[1:] &= ~shift
        moved = np.where(shift, word, 0.0)
        total = np.concatenate(([0.0], np.cumsum(moved)))
        base = last_true(given)
        logical = value[base] + (total - total[base])
        step = np.where(shift, moved, np.diff(logical))
    step[at] = 0.0
    return logical, step


def _known(word: np.ndarray, relative: np.ndarray, modal: Modal, axis: int, start: bool) -> np.ndarray:
    """Is the axis where the file says, before and after every line?

    Homing is no knowledge: where it leaves the tool (which end, which offset, the middle of the bed where Z is probed)
    is the printer's configuration, not the file's.
    """
    lost = np.concatenate((modal.lost, [line for line, _ in modal.homed])).astype(np.intp)
    if start and not len(lost):
        return np.ones(len(word) + 1, bool)
    is_set = np.concatenate(([start], (word == word) & ~relative))
    is_set[[line + 1 for line, k, _ in modal.declared if k == axis]] = True
    is_lost = np.zeros(len(word) + 1, bool)
    is_lost[lost + 1] = True
    return last_true(is_set) + start > last_true(is_lost)  # both are 0 where nothing has happened yet


def _offset(
    logical: np.ndarray, sure: np.ndarray, fixed: dict[int, float], home: set[int], start: float
) -> np.ndarray:
    """machine - logical around every line. G92 of an axis that is not known says where the machine is."""
    n = len(logical)
    if not fixed:
        return np.full(n, start)
    offset, line = [start], [0]
    for i in sorted(fixed):
        if i in home:
            offset.append(0.0)
        else:
            offset.append(offset[-1] + (float(logical[i] - logical[i + 1]) if sure[i] else 0.0))
        line.append(i + 1)
    return np.repeat(offset, np.diff(line, append=n))
