"""The planners' facts once more, one move at a time and with plain floats: what the array code has to agree with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from fbfcli.motion.moves import Moves


@dataclass
class KlipperMove:
    """One queued move of Klipper: its length, direction, limits and what the corner before it allows."""

    d: float
    r: list[float]
    toolhead: bool
    cruise: float
    accel: float
    jd: float
    smooth: float
    icv: float
    start: float = 0.0
    smooth_start: float = 0.0


def klipper_move(moves: Moves, i: int) -> KlipperMove:
    dx, dy, dz, de = (float(x) for x in moves.delta[i])
    limits = moves.limits[moves.state[i]]
    d = math.sqrt(dx * dx + dy * dy + dz * dz)
    toolhead = d >= 1e-9
    if not toolhead:
        d, dx, dy, dz = abs(de), 0.0, 0.0, 0.0
    v = min(float(moves.speed[i]), limits.velocity) if toolhead else float(moves.speed[i])
    accel = limits.acceleration if toolhead else 99999999.9
    smooth = limits.acceleration * (1.0 - limits.minimum_cruise_ratio)
    if dz:
        v = min(v, limits.axis_velocity[2] * d / abs(dz))
        accel = min(accel, limits.axis_acceleration[2] * d / abs(dz))
    if de < 0.0 or (de and not dx and not dy):
        v = min(v, limits.axis_velocity[3] * d / abs(de))
        accel = min(accel, limits.axis_acceleration[3] * d / abs(de))
    jd = limits.square_corner_velocity**2 * (math.sqrt(2.0) - 1.0) / limits.acceleration
    per_mm = 1.0 / d  # as Klipper does: at SCV = 0 the last bit of r decides whether two moves are straight
    r = [x * per_mm for x in (dx, dy, dz, de)]
    return KlipperMove(d, r, toolhead, v * v, accel, jd, min(smooth, accel), limits.jerk[3])


def klipper_corner(a: KlipperMove, b: KlipperMove) -> float:
    """w at the corner between a and b, neighbours' reach left out."""
    if not (a.toolhead and b.toolhead):
        return 0.0
    allowed = [a.cruise, b.cruise]
    e_step = abs(b.r[3] - a.r[3])
    if e_step:
        allowed.append((b.icv / e_step) ** 2)
    dot = a.r[0] * b.r[0] + a.r[1] * b.r[1] + a.r[2] * b.r[2]
    s, c = math.sqrt(max(0.5 * (1.0 + dot), 0.0)), math.sqrt(max(0.5 * (1.0 - dot), 0.0))
    if s < 1.0 and c > 0.0:
        allowed += [m.jd * m.accel * s / (1.0 - s) for m in (a, b)]
        allowed += [0.5 * m.d * m.accel * s / c for m in (a, b)]
    return min(allowed)


def klipper_durations(moves: Moves) -> list[float]:
    """Seconds of each move of Klipper's planner, from rest to rest."""
    queue = [klipper_move(moves, i) for i in range(len(moves))]
    for i, (a, b) in enumerate(pairwise(queue), start=1):
        corner = 0.0 if moves.stop[i] else klipper_corner(a, b)
        b.start = min(corner, a.start + 2 * a.accel * a.d)
        b.smooth_start = min(b.start, a.smooth_start + 2 * a.smooth * a.d)
    plans: list[tuple[float, float | None, float]] = []
    w_next = m_next = peak = 0.0
    waiting = 0
    for move in reversed(queue):
        w_reach, m_reach = w_next + 2 * move.accel * move.d, m_next + 2 * move.smooth * move.d
        w, m = min(move.start, w_reach), min(move.smooth_start, m_reach)
        cruise = None
        waiting += 1
        if m < m_reach:
            if m + 2 * move.smooth * move.d > m_next or waiting > 1:
                peak = 0.5 * (m + m_reach)
            cruise = min(0.5 * (w + w_reach), move.cruise, peak)
            waiting = 0
        plans.append((w, cruise, w_next))
        w_next, m_next = w, m
    seconds, cruise_before = [], 0.0
    for move, (w, cruise, w_end) in zip(queue, reversed(plans), strict=True):
        top = cruise_before = min(cruise_before, w) if cruise is None else cruise
        seconds.append(trapezoid_time(move.d, move.accel, min(w, top), top, min(w_end, top)))
    return seconds


def trapezoid_time(d: float, accel: float, w_start: float, w_cruise: float, w_end: float) -> float:
    v_start, v, v_end = (math.sqrt(w) for w in (w_start, w_cruise, w_end))
    up, down = (w_cruise - w_start) / (2 * accel), (w_cruise - w_end) / (2 * accel)
    return 2 * up / (v_start + v) + (d - up - down) / v + 2 * down / (v_end + v)


def marlin_speed(moves: Moves, i: int) -> tuple[float, list[float]]:
    """Nominal speed of a move and its speed along each axis."""
    delta, limits = [float(x) for x in moves.delta[i]], moves.limits[moves.state[i]]
    d = math.sqrt(sum(x * x for x in delta[:3])) or abs(delta[3])
    axes = [x / d * float(moves.speed[i]) for x in delta]
    factor = min([1.0] + [cap / abs(v) for v, cap in zip(axes, limits.axis_velocity, strict=True) if abs(v) > cap])
    return float(moves.speed[i]) * factor, [v * factor for v in axes]


def marlin_safe_speed(moves: Moves, i: int) -> float:
    """Speed from which the machine may halt at once: no axis above its jerk."""
    v, axes = marlin_speed(moves, i)
    jerk = moves.limits[moves.state[i]].jerk
    return min([v] + [v * cap / abs(x) for x, cap in zip(axes, jerk, strict=True) if abs(x) > cap])


def marlin_classic_corner(moves: Moves, i: int) -> float:
    """Speed that Marlin's classic jerk allows between moves i - 1 and i."""
    jerk = moves.limits[moves.state[i]].jerk
    (v_a, axes_a), (v_b, axes_b) = marlin_speed(moves, i - 1), marlin_speed(moves, i)
    shared, factor = min(v_a, v_b), 1.0
    for axis in range(4):
        leave, enter = axes_a[axis] * min(1.0, v_b / v_a) * factor, axes_b[axis] * factor
        reverses = (leave > 0 and enter < 0) or (leave < 0 and enter > 0)
        jump = max(abs(leave), abs(enter)) if reverses else abs(leave - enter)
        if jump > jerk[axis]:
            factor *= jerk[axis] / jump
    shared *= factor
    safe_a, safe_b = marlin_safe_speed(moves, i - 1), marlin_safe_speed(moves, i)
    if min(safe_a, safe_b) > 0.99 * shared:
        shared = min(safe_b, v_a)
    return max(shared, 0.05)
