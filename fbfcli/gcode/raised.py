"""Limits raised before a compensated stretch and put back after it, in each firmware's words.

A segment of length d lasts d/F only if the planner is not made to slow down, so its limits must not bind. X and Y are
raised; moves of Z or E alone keep the limits they had. Marlin's acceleration of E (M201) is raised too: E runs evenly
in time, but where X and Y change their speed from one segment to the next, the ratio of E to the path jumps, and Marlin
would hold the path back by E's limit. Moves of E alone have their own there (M204 R); in RepRapFirmware they have not.
Klipper: SET_VELOCITY_LIMIT, SET_INPUT_SHAPER. Marlin: M201, M203, M204, M205, M593, M493. RepRapFirmware: M201, M203
(mm/min), M204, M566 (mm/min), M593.
"""

from __future__ import annotations

from dataclasses import replace
from math import isfinite, isnan

from fbfcli.printer import Four, Limits
from fbfcli.units import S_PER_MIN

KLIPPER_VELOCITY = 5000.0
KLIPPER_ACCELERATION = 1e8
KLIPPER_CORNER = 1e5
XY_VELOCITY = 2000.0
XY_ACCELERATION = 1e6  # times 100 steps/mm still fits the planner's 32-bit steps/s^2
XY_JERK = 1000.0
E_ACCELERATION = 1e5  # a wipe then changes its speed within a millisecond; times 1,000 steps/mm it fits 32 bits as well
JUNCTION_DEVIATION = 0.3  # the most that M205 J accepts
MARLIN_SEGMENT_US = 20_000  # DEFAULT_MINSEGMENTTIME: M205 B0 keeps Marlin from stretching short segments


def raised(firmware: str, limits: Limits) -> Limits:
    """The limits in force inside a compensated stretch, as the planner model sees them."""
    if firmware == "klipper":
        return replace(
            limits,
            velocity=KLIPPER_VELOCITY,
            acceleration=KLIPPER_ACCELERATION,
            square_corner_velocity=KLIPPER_CORNER,
            minimum_cruise_ratio=0.0,
        )
    deviation = limits.junction_deviation
    return replace(
        limits,
        acceleration=XY_ACCELERATION,
        travel_acceleration=XY_ACCELERATION,
        axis_velocity=_xy(limits.axis_velocity, XY_VELOCITY),
        axis_acceleration=_with_e(firmware, _xy(limits.axis_acceleration, XY_ACCELERATION)),
        jerk=_xy(limits.jerk, XY_JERK),
        junction_deviation=deviation if isnan(deviation) else JUNCTION_DEVIATION,
    )


def _xy(values: Four, top: float) -> Four:
    """X and Y raised to `top`; an entry that is unlimited is left so (it could not be put back)."""
    x, y = (top if isfinite(v) else v for v in values[:2])
    return (x, y, values[2], values[3])


def _with_e(firmware: str, acceleration: Four) -> Four:
    """E raised as well where moves of E alone do not heed it; an unlimited one is left so."""
    x, y, z, e = acceleration
    return (x, y, z, max(e, E_ACCELERATION)) if firmware == "marlin" else acceleration


def shaper_off(firmware: str) -> list[str]:
    """Lines that switch off the firmware's own vibration compensation, which would act on top of ours."""
    if firmware == "klipper":
        return ["SET_INPUT_SHAPER SHAPER_FREQ_X=0 SHAPER_FREQ_Y=0"]
    if firmware == "marlin":
        return ["M593 F0", "M493 S0"]  # a build without the one or the other answers "unknown command" and goes on
    return ['M593 P"none"']


def raise_lines(firmware: str, limits: Limits) -> list[str]:
    """Lines before a compensated stretch where `limits` are in force."""
    return shaper_off(firmware) + limit_lines(firmware, raised(firmware, limits), limits)


def restore_lines(firmware: str, limits: Limits, base: Limits) -> list[str]:
    """Lines after it that put `limits` in force.

    base : the limits that were raised; what has changed since for Z and E (such lines wait, see `runs`) is put in force
           too
    """
    segment_time = [f"M205 B{MARLIN_SEGMENT_US}"] if firmware == "marlin" else []
    return _limit_lines(firmware, limits, raised(firmware, base), "XYZE") + segment_time


def limit_lines(firmware: str, limits: Limits, base: Limits) -> list[str]:
    """Lines that put `limits` in force instead of `base`, and keep the firmware from stretching short moves."""
    segment_time = ["M205 B0"] if firmware == "marlin" else []
    return _limit_lines(firmware, limits, base, "XYE") + segment_time


def _limit_lines(firmware: str, limits: Limits, base: Limits, axes: str) -> list[str]:
    """Lines that put `limits` in force for X and Y, and for the other `axes` where they differ from `base`."""
    if firmware == "klipper":
        return [
            f"SET_VELOCITY_LIMIT VELOCITY={_number(limits.velocity)} ACCEL={_number(limits.acceleration)} "
            f"SQUARE_CORNER_VELOCITY={_number(limits.square_corner_velocity)} "
            f"MINIMUM_CRUISE_RATIO={_number(limits.minimum_cruise_ratio)}"
        ]
    per_min = S_PER_MIN if firmware == "reprapfirmware" else 1.0
    retract = limits.retract_acceleration
    lines = [
        _axis_line("M201", limits.axis_acceleration, base.axis_acceleration, axes, 1.0),
        _axis_line("M203", limits.axis_velocity, base.axis_velocity, axes, per_min),
        f"M204 P{_number(limits.acceleration)} T{_number(limits.travel_acceleration)}"
        + (f" R{_number(retract)}" if firmware == "marlin" and retract != base.retract_acceleration else ""),
    ]
    if firmware == "reprapfirmware":
        lines.append(_axis_line("M566", limits.jerk, base.jerk, axes, per_min))
    else:
        lines.append(_axis_line("M205", limits.jerk, base.jerk, axes, 1.0, f"J{_number(limits.junction_deviation)}"
                                if not isnan(limits.junction_deviation) else ""))  # fmt: skip
    return [line for line in lines if line]


def _axis_line(command: str, values: Four, base: Four, axes: str, scale: float, instead: str = "") -> str:
    """`command` with a word per axis; `instead` of X and Y another word."""
    words = [instead] if instead else []
    for axis, value, was in zip("XYZE", values, base, strict=True):
        plane = axis in "XY" and not instead
        if axis in axes and isfinite(value) and (plane or (axis in "ZE" and value != was)):
            words.append(f"{axis}{_number(value * scale)}")
    return " ".join([command, *words]) if words else ""


def _number(value: float) -> str:
    """Shortest decimal form without an exponent: firmwares read 1e8 as 1."""
    return f"{value:.6f}".rstrip("0").rstrip(".")
