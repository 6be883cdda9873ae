"""A sweep as a file of G-code for one machine: limits, way to the middle, swings, limits put back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fbfcli.gcode.raised import limit_lines, restore_lines, shaper_off
from fbfcli.gcode.words import feed_words, g1_lines, to_words
from fbfcli.plant.square_sweep import Swings
from fbfcli.printer import Limits, Printer
from fbfcli.units import S_PER_MIN

REVERSAL = 0.1  # mm/s, jerk while it runs: a swing must end at rest. RepRapFirmware takes no less
APPROACH = 50.0  # mm/s, to the middle
LIFT = 10.0  # mm above the bed, where the travel allows it
BEGIN, END = "; swings begin", "; swings end"


@dataclass(frozen=True)
class SweepFile:
    """The text, and which of its lines (from 0) are swings: first, and one behind the last."""

    text: bytes
    first: int
    last: int


def sweep_file(printer: Printer, axis: int, swings: Swings, start: float, about: list[str]) -> SweepFile:
    """The file of swings of X (0) or Y (1) from `start` [mm]; `about`: comments at its top."""
    letter = "XY"[axis]
    head = [*(f"; {line}" for line in about), "G21", "G90", "G28", *shaper_off(printer.firmware), *_way(printer)]
    head.append(f"G1 {letter}{start:.5f} F{APPROACH * S_PER_MIN:g}")
    head += ["M400", BEGIN]
    word = to_words(start + np.cumsum(swings.distance))
    feed = feed_words(swings.speed * S_PER_MIN)
    body: list[bytes] = []
    at = np.flatnonzero(np.diff(swings.acceleration, prepend=-1.0))
    for a, b in zip(at, [*at[1:], len(swings)], strict=True):
        limits = in_force(printer.limits, axis, float(swings.acceleration[a]), float(swings.speed.max()))
        body += [line.encode() + b"\n" for line in limit_lines(printer.firmware, limits, printer.limits)]
        new = np.diff(feed[a:b], prepend=0) != 0
        body.append(g1_lines([(letter, word[a:b], None), ("F", feed[a:b], new)])[0])
    tail = [END, "M400", *restore_lines(printer.firmware, printer.limits, printer.limits), ""]
    lead = "\n".join(head).encode() + b"\n"
    middle = b"".join(body)
    first = lead.count(b"\n")
    return SweepFile(lead + middle + "\n".join(tail).encode(), first, first + middle.count(b"\n"))


def in_force(limits: Limits, axis: int, a: float, v: float) -> Limits:
    """The limits while swings of acceleration `a` and speed up to `v` run."""
    jerk = list(limits.jerk)
    jerk[axis] = min(REVERSAL, jerk[axis])
    return replace(limits, acceleration=a, travel_acceleration=a, velocity=max(v, limits.velocity),
                   jerk=(jerk[0], jerk[1], jerk[2], jerk[3]), minimum_cruise_ratio=0.0)  # fmt: skip


def _way(printer: Printer) -> list[str]:
    """Off the bed, and to the middle of it."""
    (x_low, x_high), (y_low, y_high), (z_low, z_high) = (axis.travel for axis in printer.axes)
    z = min(max(z_low, 0.0) + LIFT, z_high)
    return [f"G1 Z{z:g} F{_z_speed(printer) * S_PER_MIN:g}",
            f"G1 X{0.5 * (x_low + x_high):.3f} Y{0.5 * (y_low + y_high):.3f} F{APPROACH * S_PER_MIN:g}"]  # fmt: skip


def _z_speed(printer: Printer) -> float:
    return float(min(printer.limits.axis_velocity[2], 5.0))
