"""What each firmware allows along a move and at the corner before it.

    d  length of a move along X, Y, Z, or along E where only E moves [mm]
    r  displacement of X, Y, Z, E per mm of d
    w  squared speed [mm^2/s^2], a acceleration [mm/s^2]
    s  cos(phi / 2) of the turning angle phi; R = s / (1 - s)

Klipper of 2025: klippy/toolhead.py Move, klippy/kinematics/extruder.py check_move and calc_junction, cartesian.py.
Marlin 2.0 and 2.1: Marlin/src/module/planner.cpp, Planner::_populate_block (classic jerk as in the releases; the
development branch has since dropped the safe speed).
RepRapFirmware: src/Movement/DDA.cpp, Init, DoLookahead and MatchSpeeds.

Queues are taken as long enough: the firmware always sees as far ahead as it needs. Steps, and with them Marlin's
merging of moves of a few steps, are not modelled here (`verify.firmware` does); nor is the start from standstill at
Marlin's safe speed: a stop is w = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fbfcli.motion.moves import EPS_MM, E, Moves, X, Y, Z

KLIPPER_E_ACCEL = 99999999.9  # of a move of E alone before its own limits (toolhead.py)
MARLIN_MIN_W = 0.05**2  # MINIMUM_PLANNER_SPEED
REPRAP_MIN_SPEED = 0.5  # MinimumMovementSpeed [mm/s]
COS_REVERSAL = 0.999999  # Marlin: a sharper turn than this is a stop, a smaller one is straight


@dataclass(frozen=True)
class Corners:
    """What n moves allow. w = v^2 [mm^2/s^2], acceleration [mm/s^2].

    cruise : ndarray, shape (n,)  highest w of the move itself
    accel  : ndarray, shape (n,)  acceleration along the move
    entry  : ndarray, shape (n,)  highest w where the move begins; 0 at a stop
    smooth : ndarray, shape (n,)  acceleration of Klipper's smoothed plan (minimum_cruise_ratio), `accel` elsewhere
    """

    cruise: np.ndarray
    accel: np.ndarray
    entry: np.ndarray
    smooth: np.ndarray

    def __len__(self) -> int:
        return len(self.cruise)

    def __getitem__(self, part: slice) -> Corners:
        accel = self.accel[part]
        smooth = accel if self.smooth is self.accel else self.smooth[part]
        return Corners(self.cruise[part], accel, self.entry[part], smooth)


class Paths(NamedTuple):
    """Moves by themselves, before their corners. Shapes (n,), r (4, n), rule (k, n)."""

    r: np.ndarray
    d: np.ndarray
    w: np.ndarray
    a: np.ndarray
    smooth: np.ndarray
    kind: np.ndarray  # where it changes the machine stops
    rule: np.ndarray  # limits that the firmware's corner rule reads

    def part(self, part: slice) -> Paths:
        return Paths(*(rows[..., part] for rows in self))


def corner_limits(moves: Moves, firmware: str, previous: Moves | None = None) -> Corners:
    """The limits of `firmware` ("klipper", "marlin", "reprapfirmware") along and between n moves.

    previous : the one move before these, for the first corner; None: the machine is at rest there
    Firmwares drop moves of no length: leave them out, or they stop the machine. Raises KeyError for another firmware.
    """
    paths, corner = RULES[firmware]
    own = paths(moves)
    entry = np.zeros(len(moves))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if len(moves) > 1:
            entry[1:] = corner(own.part(slice(None, -1)), own.part(slice(1, None)))
        if previous is not None and len(moves):
            entry[:1] = corner(paths(previous), own.part(slice(0, 1)))
    entry[moves.stop] = 0.0
    return Corners(own.w, own.a, entry, own.smooth)


def standing_start(moves: Moves, firmware: str) -> np.ndarray:
    """The w that each of n moves begins with where the machine stands, shape (n,).

    Marlin starts at the speed from which it may halt at once, with junction deviation at the minimum planner speed.
    """
    if firmware != "marlin":
        return np.zeros(len(moves))
    paths = marlin_paths(moves)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        safe = np.minimum(paths.w, _box(paths.r, paths.rule[1:5]) ** 2)
    return np.where(np.isnan(paths.rule[0]), safe, np.minimum(MARLIN_MIN_W, paths.w))


def klipper_paths(moves: Moves) -> Paths:
    """Speed capped by max_velocity, Z by max_z_*, E alone, retractions and wipes by max_extrude_only_*."""
    r, d, alone = _directions(moves)
    v = np.where(alone, moves.speed, np.minimum(moves.speed, moves.limit("velocity")))
    a_max = moves.limit("acceleration")
    a = np.where(alone, KLIPPER_E_ACCEL, a_max)
    _cap_axis(moves, Z, np.flatnonzero(r[Z]), r, v, a)
    _cap_axis(moves, E, np.flatnonzero((r[E] < 0.0) | ((r[E] > 0.0) & (r[X] == 0.0) & (r[Y] == 0.0))), r, v, a)
    smooth = np.minimum(a_max * (1.0 - moves.limit("minimum_cruise_ratio")), a)
    deviation = moves.limit("square_corner_velocity")**2 * (np.sqrt(2.0) - 1.0) / a_max
    rule = np.stack((deviation * a, moves.limit("jerk", E)))
    return Paths(r, d, v * v, a, smooth, alone, rule)


def klipper_corner(before: Paths, after: Paths) -> np.ndarray:
    """min of both cruise speeds, R jd a and d a tan / 2 of both moves, and the extruder's instantaneous corner speed.

    With cos(theta) = -r . r' as in calc_junction: s = sin(theta / 2), the centripetal limit a d s / (2 cos(theta / 2)).
    """
    dot = before.r[X] * after.r[X] + before.r[Y] * after.r[Y] + before.r[Z] * after.r[Z]
    s = np.sqrt(np.maximum(0.5 + 0.5 * dot, 0.0))
    c = np.sqrt(np.maximum(0.5 - 0.5 * dot, 0.0))
    turn = s / (1.0 - s) * np.minimum(before.rule[0], after.rule[0])
    arc = 0.5 * s / c * np.minimum(before.d * before.a, after.d * after.a)
    w = np.minimum(before.w, after.w)
    np.fmin(w, turn, out=w, where=s < 1.0)
    np.fmin(w, arc, out=w, where=(c > 0.0) & (s < 1.0))
    step = after.r[E] - before.r[E]
    np.fmin(w, np.square(after.rule[1] / step), out=w, where=step != 0.0)
    w[before.kind | after.kind] = 0.0
    return w


def marlin_paths(moves: Moves) -> Paths:
    """Speed and acceleration capped axis by axis (M203, M201) from M204 P, T or R; E alone is not capped by M201."""
    r, d, alone = _directions(moves)
    a = np.where(r[E] != 0.0, moves.limit("acceleration"), moves.limit("travel_acceleration"))
    axis_a = moves.limit("axis_acceleration").T
    v = np.minimum(moves.speed, _box(r, moves.limit("axis_velocity").T))
    a = np.where(alone, moves.limit("retract_acceleration"), np.minimum(a, _box(r, axis_a)))
    rule = np.concatenate((moves.limit("junction_deviation")[None], moves.limit("jerk").T, axis_a))
    return Paths(r, d, v * v, a, a, alone, rule)


def marlin_corner(before: Paths, after: Paths) -> np.ndarray:
    """Junction deviation where M205 J is set, classic jerk elsewhere; never slower than the minimum planner speed."""
    classic = np.isnan(after.rule[0])
    if not classic.any():
        w = _marlin_deviation(before, after)
    elif classic.all():
        w = _marlin_jerk(before, after)
    else:
        w = np.where(classic, _marlin_jerk(before, after), _marlin_deviation(before, after))
    return np.maximum(w, MARLIN_MIN_W)


def _marlin_deviation(before: Paths, after: Paths) -> np.ndarray:
    """w = a_j jd s / (1 - s), a_j capped per axis along u - u_before, u of length 1 in X, Y, Z and E together.

    Short segments that turn little are taken for an arc: w <= a_j d / theta (JD_HANDLE_SMALL_SEGMENTS; Marlin's table
    of acos is off by up to 0.01 rad).
    """
    u, u_before = _unit(after.r), _unit(before.r)
    cos = -(u * u_before).sum(axis=0)
    change = _unit(u - u_before)
    a = np.minimum(after.a, _box(change, after.rule[5:]))
    cos_safe = np.maximum(cos, -COS_REVERSAL)
    s = np.sqrt(0.5 * (1.0 - cos_safe))
    w = a * after.rule[0] * s / (1.0 - s)
    arc = np.flatnonzero((after.d < 1.0) & (cos < -np.sqrt(0.5)))
    w[arc] = np.minimum(w[arc], after.d[arc] * a[arc] / np.arccos(-cos_safe[arc]))
    w[cos > COS_REVERSAL] = 0.0
    return np.minimum(w, np.minimum(before.w, after.w))


def _marlin_jerk(before: Paths, after: Paths) -> np.ndarray:
    """Classic jerk: the slower of both speeds, scaled until no axis jumps by more than its jerk.

    An axis that reverses counts its larger speed only. Where both moves could as well halt and start, the speed from
    which the machine may halt at once is taken (safe speed); Marlin forgets to cap it at the speed of the move before.
    """
    jerk = after.rule[1:5]
    v_before, v = np.sqrt(before.w), np.sqrt(after.w)
    v_corner = np.minimum(v_before, v)
    scale = np.minimum(v / v_before, 1.0)
    factor = np.ones_like(v)
    for axis in (X, Y, Z, E):
        leave, enter = before.r[axis] * v_before * scale * factor, after.r[axis] * v * factor
        jump = np.where(leave * enter >= 0.0, np.abs(leave - enter), np.maximum(np.abs(leave), np.abs(enter)))
        np.multiply(factor, jerk[axis] / jump, out=factor, where=jump > jerk[axis])
    v_corner *= factor
    safe, safe_before = np.minimum(v, _box(after.r, jerk)), np.minimum(v_before, _box(before.r, before.rule[1:5]))
    halting = np.minimum(safe, safe_before) > 0.99 * v_corner
    return np.square(np.where(halting, np.minimum(safe, v_before), v_corner))


def reprap_paths(moves: Moves) -> Paths:
    """Speed and acceleration are the box M203, M201 along r; M204 P (extruding) or T only where X or Y move."""
    r, d, _ = _directions(moves)
    flat = (r[X] != 0.0) | (r[Y] != 0.0)
    printing = flat & (r[E] > 0.0)
    v = np.minimum(np.maximum(moves.speed, REPRAP_MIN_SPEED), _box(r, moves.limit("axis_velocity").T))
    a_flat = np.where(printing, moves.limit("acceleration"), moves.limit("travel_acceleration"))
    a = np.minimum(_box(r, moves.limit("axis_acceleration").T), np.where(flat, a_flat, np.inf))
    a = np.where(np.isfinite(a), a, moves.limit("retract_acceleration"))
    return Paths(r, d, v * v, a, a, flat + 2 * printing, moves.limit("jerk").T)


def reprap_corner(before: Paths, after: Paths) -> np.ndarray:
    """min of both speeds and jerk / |r - r_before| of each axis; 0 between printing and travel (jerk policy 0)."""
    w = np.minimum(np.minimum(before.w, after.w), _box(after.r - before.r, after.rule)**2)
    return np.where(before.kind == after.kind, w, 0.0)


RULES = {
    "klipper": (klipper_paths, klipper_corner),
    "marlin": (marlin_paths, marlin_corner),
    "reprapfirmware": (reprap_paths, reprap_corner),
}


def _directions(moves: Moves) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """r, d and where E moves alone. A move shorter than EPS_MM in all axes has r = 0."""
    delta = np.array(moves.delta.T, order="C")  # a copy: it becomes r
    d = np.sqrt(delta[X]**2 + delta[Y]**2 + delta[Z]**2)
    alone = d <= EPS_MM
    if alone.any():
        delta[:E, alone] = 0.0
        d[alone] = np.abs(delta[E, alone])
    delta *= np.divide(1.0, d, out=np.zeros_like(d), where=d > 0.0)
    return delta, d, alone


def _box(r: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Largest multiple of r, shape (4, n), that stays within +-limits in each axis."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = [np.where(r[axis] != 0.0, limits[axis] / np.abs(r[axis]), np.inf) for axis in (X, Y, Z, E)]
    return np.minimum(np.minimum(reach[X], reach[Y]), np.minimum(reach[Z], reach[E]))


def _unit(r: np.ndarray) -> np.ndarray:
    """r, shape (4, n), scaled to length 1; 0 stays 0."""
    length = np.sqrt((r * r).sum(axis=0))
    return r * np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)


def _cap_axis(moves: Moves, axis: int, part: np.ndarray, r: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
    """Cap v and a of the moves `part` in place so that `axis` stays within its limits."""
    ratio = 1.0 / np.abs(r[axis, part])
    v[part] = np.minimum(v[part], ratio * moves.limit("axis_velocity", axis, part))
    a[part] = np.minimum(a[part], ratio * moves.limit("axis_acceleration", axis, part))

