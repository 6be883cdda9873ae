"""Arcs (G2, G3) and cubic splines (G5) as chords, all curves of a block at once.

A chord that spans the angle a of a circle of radius r leaves it by the sagitta r (1 - cos(a / 2)); a chord of a curve
x(t) over dt leaves it by at most |x''| dt^2 / 8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.errors import GcodeError

TOLERANCE_MM = 1e-3  # a micrometre: far below a motor step
LONGEST_MM = 1.0  # Z and E are linear along an arc, and so is what is done to it later
SAME_MM = 1e-6  # an arc that ends where it starts is a full circle
R_SLACK = 0.01  # relative: ends printed with few decimals may be farther apart than 2 R
MAX_CHORDS = 1_000_000  # of one curve


@dataclass(frozen=True)
class Chords:
    """Straight pieces of m curves, in order.

    count : ndarray of int, shape (m,)         pieces of each curve
    start, delta : ndarray, shape (sum, 4)     X, Y, Z, E before each piece, and its displacement [mm]
    """

    count: np.ndarray
    start: np.ndarray
    delta: np.ndarray


def arc_centres(start: np.ndarray, end: np.ndarray, i: np.ndarray, j: np.ndarray, r: np.ndarray,
                clockwise: np.ndarray) -> np.ndarray:  # fmt: skip
    """Centres, shape (m, 2), of arcs given by I and J (from the start) or by R; nan where a word is absent.

    By R, the centre is d/2 + n sqrt(R^2 - |d|^2 / 4) from the start: d the chord, n its left normal, taken to the right
    for a clockwise arc and on the other side for R < 0 (the longer way round). Raises GcodeError, whose `line` is the
    index of the arc.
    """
    offset = np.stack((np.nan_to_num(i), np.nan_to_num(j)), axis=1)
    by_offset = ~(np.isnan(i) & np.isnan(j))
    by_radius = ~by_offset & ~np.isnan(r)
    _refuse(~by_offset & ~by_radius, "an arc needs I, J or R", "give the centre with I and J")
    _refuse(by_offset & ~offset.any(axis=1), "an arc needs a radius above zero", "I and J are both zero")
    if by_radius.any():
        chord = end[by_radius, :2] - start[by_radius, :2]
        length = np.hypot(chord[:, 0], chord[:, 1])
        radius = r[by_radius]
        far, none = np.zeros(len(r), bool), np.zeros(len(r), bool)
        none[by_radius] = length < SAME_MM
        far[by_radius] = length > 2 * np.abs(radius) * (1 + R_SLACK)
        _refuse(none, "an arc by R must end elsewhere than it starts", "write a full circle with I and J")
        _refuse(far, "the arc's end is farther away than twice R", "correct R, or give I and J")
        height = np.sqrt(np.maximum(radius**2 - length**2 / 4, 0.0))
        side = np.where(clockwise[by_radius] ^ (radius < 0), -1.0, 1.0) * height / length
        offset[by_radius] = chord / 2 + np.stack((-chord[:, 1], chord[:, 0]), axis=1) * side[:, None]
    return start[:, :2] + offset


def chord_arcs(start: np.ndarray, end: np.ndarray, centre: np.ndarray, clockwise: np.ndarray,
               tolerance: float = TOLERANCE_MM) -> Chords:  # fmt: skip
    """Arcs in X and Y, shapes (m, 4), (m, 4), (m, 2), (m,); Z and E are linear in the angle, the end is exact.

    As in Marlin (`G2_G3.cpp`) and Klipper (`gcode_arcs.py`) the radius is the start's; where the end is not on that
    circle, the last piece leads straight to it. Raises GcodeError, whose `line` is the
    index of the arc.
    """
    a, b = start[:, :2] - centre, end[:, :2] - centre
    radius = np.hypot(a[:, 0], a[:, 1])
    turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]) % (2 * np.pi)
    turn = np.where(clockwise, turn - 2 * np.pi, turn)
    full = np.abs(end[:, :2] - start[:, :2]).max(axis=1) < SAME_MM
    turn = np.where(full, np.where(clockwise, -2 * np.pi, 2 * np.pi), turn)
    widest = 2 * np.arccos(np.maximum(1 - tolerance / np.maximum(radius, tolerance), 0.0))
    widest = np.minimum(widest, LONGEST_MM / np.maximum(radius, tolerance))
    count = _counts(np.abs(turn) / widest)
    curve, fraction = _along(count)
    angle = np.arctan2(a[:, 1], a[:, 0])[curve] + turn[curve] * fraction
    points = start[curve] + (end - start)[curve] * fraction[:, None]
    points[:, 0] = centre[curve, 0] + radius[curve] * np.cos(angle)
    points[:, 1] = centre[curve, 1] + radius[curve] * np.sin(angle)
    return _pieces(start, end, count, points)


def chord_splines(start: np.ndarray, end: np.ndarray, leave: np.ndarray, arrive: np.ndarray,
                  tolerance: float = TOLERANCE_MM) -> Chords:  # fmt: skip
    """Cubic Bezier curves of G5; control points `leave` (I, J) from the start, `arrive` (P, Q) from the end, (m, 2).

    |x''| is largest at an end of a cubic; Z and E are linear in the parameter. Raises GcodeError.
    """
    p0, p3 = start[:, :2], end[:, :2]
    p1, p2 = p0 + leave, p3 + arrive
    bend = 6 * np.maximum(np.hypot(*(p0 - 2 * p1 + p2).T), np.hypot(*(p1 - 2 * p2 + p3).T))
    speed = 3 * np.maximum.reduce([np.hypot(*(p1 - p0).T), np.hypot(*(p2 - p1).T), np.hypot(*(p3 - p2).T)])
    count = _counts(np.maximum(np.sqrt(bend / (8 * tolerance)), speed / LONGEST_MM))
    curve, t = _along(count)
    points = start[curve] + (end - start)[curve] * t[:, None]
    s, t = (1 - t)[:, None], t[:, None]
    points[:, :2] = s**3 * p0[curve] + 3 * s**2 * t * p1[curve] + 3 * s * t**2 * p2[curve] + t**3 * p3[curve]
    return _pieces(start, end, count, points)


def _counts(pieces: np.ndarray) -> np.ndarray:
    """Whole numbers of chords, at least one."""
    _refuse(~(pieces < MAX_CHORDS), "a curve is too long to be split into chords", "check I, J and R")
    return np.maximum(np.ceil(pieces - 1e-9), 1).astype(np.intp)


def _along(count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For every piece, the curve it belongs to and the fraction of it that is done at its end."""
    curve = np.repeat(np.arange(len(count)), count)
    before = np.cumsum(count) - count
    return curve, (np.arange(len(curve)) - before[curve] + 1) / count[curve]


def _pieces(start: np.ndarray, end: np.ndarray, count: np.ndarray, points: np.ndarray) -> Chords:
    """Chords that end at `points`, shape (sum, 4); the last of each curve exactly at its end."""
    last = np.cumsum(count) - 1
    points[last] = end
    before = np.empty_like(points)
    before[1:] = points[:-1]
    before[last - count + 1] = start
    return Chords(count, before, points - before)


def _refuse(wrong: np.ndarray, why: str, remedy: str) -> None:
    if wrong.any():
        raise GcodeError(why, line=int(np.flatnonzero(wrong)[0]), remedy=remedy)
