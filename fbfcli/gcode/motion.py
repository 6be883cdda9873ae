"""Motion lines to straight moves: feed rates, curves, rests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.errors import GcodeError
from fbfcli.gcode.arcs import Chords, arc_centres, chord_arcs, chord_splines
from fbfcli.gcode.coordinates import Track, last_true
from fbfcli.gcode.modal import Modal, at_line
from fbfcli.gcode.scan import G2, G3, G5, LETTERS, MODAL, Lines
from fbfcli.gcode.state import State
from fbfcli.motion.moves import EPS_MM, Moves
from fbfcli.units import MM_PER_INCH, S_PER_MIN

DEFAULT_FEED = 1500.0  # mm/min: Klipper's 25 mm/s before the first F
ABSURD = 1e7  # mm, or mm/min: ten kilometres
CURVE_WORDS = "XYZEIJR"


@dataclass(frozen=True)
class Feed:
    """Feed rates of n lines.

    written : ndarray, shape (n + 1,)  F in force as written, nan before the first; entry 0 is before line 0
    speed   : ndarray, shape (n,)      after the line, speed factor included [mm/s]
    unit    : float                    of the last entry of `written` [mm]
    """

    written: np.ndarray
    speed: np.ndarray
    unit: float


def refuse_absurd(lines: Lines) -> None:
    """Raise GcodeError for a feed rate that is not above zero, or a number no machine can mean."""
    for name in LETTERS:
        wrong = np.abs(lines.words[name]) > ABSURD
        if wrong.any():
            raise at_line(GcodeError(f"{name} is absurdly large", remedy="correct the number"), lines, _first(wrong))
    stopped = lines.words["F"] <= 0
    if stopped.any():
        why = GcodeError("F must be above zero", remedy="give a feed rate in mm/min, or remove the word")
        raise at_line(why, lines, _first(stopped))


def motion_modes(lines: Lines, state: State) -> np.ndarray:
    """G0 G1 G2 G3 G5 in force after each line; entry 0 is before line 0, shape (n + 1,)."""
    code = np.concatenate(([state.motion_mode], lines.code))
    return code[last_true((code >= 0) & (code != MODAL))]


def feeds(lines: Lines, modal: Modal, state: State) -> Feed:
    """Feed rates; F in inches per minute where it was written under G20."""
    written = np.concatenate(([state.feed], lines.words["F"]))
    source = last_true(written == written)
    written = written[source]
    speed, unit = written[1:] * modal.speed_factor, state.feed_unit
    if modal.inch.any() or unit != 1.0:
        units = np.concatenate(([unit], np.where(modal.inch, MM_PER_INCH, 1.0)))[source]
        speed, unit = speed * units[1:], float(units[-1])
    if np.isnan(state.feed):
        speed = np.where(np.isnan(written[1:]), DEFAULT_FEED * modal.speed_factor, speed)
    return Feed(written, speed / S_PER_MIN, unit)


def moves_of(
    lines: Lines, modal: Modal, way: Track, mode: np.ndarray, speed: np.ndarray, state: State
) -> tuple[Moves, bool]:
    """Straight moves of a block, and whether the machine rests after them. Raises GcodeError."""
    moving = np.zeros(len(lines), bool)
    for step in way.step:
        moving |= np.abs(step) > EPS_MM
    curve = _curves(lines, mode)
    if curve is not None:
        moving |= curve
    at = np.flatnonzero(moving)
    start, delta = np.empty((4, len(at))), np.empty((4, len(at)))
    for axis in range(4):
        np.add(way.logical[axis][at], way.offset[axis][at], out=start[axis])
        np.take(way.step[axis], at, out=delta[axis])
    if curve is not None and curve.any():
        at, start, delta = _with_chords(lines, modal, mode, at, curve[at], start, delta)
    stop = np.zeros(len(at), bool)
    next_move = np.searchsorted(at, modal.stops)
    stop[next_move[next_move < len(at)]] = True
    if len(at):
        stop[0] |= state.resting
    resting = bool((next_move == len(at)).any()) or (state.resting and not len(at))
    return Moves(start.T, delta.T, speed[at], stop, modal.in_force[at], at + lines.first, modal.limits), resting


def _curves(lines: Lines, mode: np.ndarray) -> np.ndarray | None:
    """Which lines are arcs or splines; None where there are none."""
    curve = (mode >= G2) & (lines.code >= 0)
    if not curve.any():
        return None
    asked = np.zeros(len(lines), bool)
    for name in CURVE_WORDS:
        asked |= ~np.isnan(lines.words[name])
    return curve & asked


def _with_chords(lines: Lines, modal: Modal, mode: np.ndarray, at: np.ndarray, curve: np.ndarray,
                 start: np.ndarray, delta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Line, start and delta of every move, curves replaced by their chords."""
    for g in (G2, G3, G5):
        which = curve & (mode[at] == g)
        if which.any():
            chords = _chords(lines, modal, g, at[which], start.T[which], delta.T[which])
            counts = np.ones(len(at), np.intp)
            counts[which] = chords.count
            piece = np.repeat(which, counts)
            at, curve = np.repeat(at, counts), np.repeat(curve, counts)
            start, delta = np.repeat(start, counts, axis=1), np.repeat(delta, counts, axis=1)
            start[:, piece], delta[:, piece] = chords.start.T, chords.delta.T
    return at, start, delta


def _chords(lines: Lines, modal: Modal, g: int, at: np.ndarray, start: np.ndarray, delta: np.ndarray) -> Chords:
    """Chords of the curves on the lines `at`, all of kind `g`."""
    flat = modal.plane[at] != 17
    if flat.any():
        why = GcodeError("arcs in the XZ or YZ plane are not supported", remedy="use G17, or straight moves")
        raise at_line(why, lines, int(at[_first(flat)]))
    scale = np.where(modal.inch[at], MM_PER_INCH, 1.0)
    i, j, p, q, r = (lines.words[name][at] * scale for name in "IJPQR")
    end = start + delta
    try:
        if g == G5:
            lacking = np.isnan(p + q)
            if lacking.any():
                raise GcodeError("G5 needs P and Q", line=_first(lacking), remedy="give the second control point")
            leave = np.stack((np.nan_to_num(i), np.nan_to_num(j)), axis=1)
            return chord_splines(start, end, leave, np.stack((p, q), axis=1))
        many = lines.words["P"][at] > 1
        if many.any():
            raise GcodeError("several turns (P) are not supported", line=_first(many), remedy="write one arc per turn")
        clockwise = np.full(len(at), g == G2)
        return chord_arcs(start, end, arc_centres(start, end, i, j, r, clockwise), clockwise)
    except GcodeError as error:
        raise at_line(error, lines, int(at[error.line or 0])) from None


def _first(mask: np.ndarray) -> int:
    return int(np.flatnonzero(mask)[0])
