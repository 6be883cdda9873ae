"""How commands change the planner's limits in each firmware.

Facts: Marlin `src/gcode/config/M200-M205.cpp` (M204 S sets printing and travel, M203 is in mm/s), Klipper `toolhead.py`
(M204 needs S, or P and T; ACCEL_TO_DECEL is the old form of MINIMUM_CRUISE_RATIO), RepRapFirmware `GCodes2.cpp` and
`Move.cpp` (M203 and M566 are in mm/min, M203 S1 and M205 in mm/s; M204 S sets both accelerations as in Marlin).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from fbfcli.errors import GcodeError
from fbfcli.printer import Limits
from fbfcli.units import S_PER_MIN


class Parameters(Protocol):
    """A parsed command: `number` of a parameter, or None; `axes` by number."""

    @property
    def name(self) -> str: ...
    def number(self, key: str) -> float | None: ...
    def axes(self) -> dict[int, float]: ...


@dataclass(frozen=True)
class Change:
    """One entry of `Limits` gets a value; `axis` where the entry has one per axis."""

    name: str
    value: float
    axis: int | None = None


def changed(limits: Limits, changes: tuple[Change, ...]) -> Limits:
    """`limits` after `changes`. "accel_to_decel" becomes 1 - min(1, value / acceleration), toolhead.py."""
    for change in changes:
        if change.name == "accel_to_decel":
            ratio = 1.0 - min(1.0, change.value / limits.acceleration)
            limits = replace(limits, minimum_cruise_ratio=ratio)
        elif change.axis is None:
            limits = _with(limits, change.name, change.value)
        else:
            values = list(getattr(limits, change.name))
            values[change.axis] = change.value
            limits = _with(limits, change.name, tuple(values))
    return limits


def _with(limits: Limits, name: str, value: Any) -> Limits:
    return replace(limits, **{name: value})


def _positive(command: Parameters, key: str, name: str, zero: bool = False) -> tuple[Change, ...]:
    value = command.number(key)
    if value is None:
        return ()
    if value < 0 or (value == 0 and not zero):
        raise GcodeError(f"{command.name} {key} must be above zero", remedy="correct the line, or remove it")
    return (Change(name, value),)


def _per_axis(name: str, unit: float = 1.0) -> Callable[[Parameters], tuple[Change, ...]]:
    """Command with X Y Z E; `unit` is what one mm/s, or mm/s^2, is in its numbers. Only a jerk can be zero."""
    zero = name == "jerk"

    def changes(command: Parameters) -> tuple[Change, ...]:
        axes = command.axes().items()
        return tuple(Change(name, value / unit, axis) for axis, value in axes if value > 0 or (zero and value == 0))

    return changes


def _marlin_m204(command: Parameters) -> tuple[Change, ...]:
    return (
        _positive(command, "S", "acceleration")
        + _positive(command, "S", "travel_acceleration")
        + _positive(command, "P", "acceleration")
        + _positive(command, "R", "retract_acceleration")
        + _positive(command, "T", "travel_acceleration")
    )


def _marlin_m205(command: Parameters) -> tuple[Change, ...]:
    """S, T (lowest speeds) and B (shortest segment) are no limits."""
    return _per_axis("jerk")(command) + _positive(command, "J", "junction_deviation")


def _reprap_m203(command: Parameters) -> tuple[Change, ...]:
    return _per_axis("axis_velocity", 1.0 if command.number("S") == 1 else S_PER_MIN)(command)


def _reprap_m204(command: Parameters) -> tuple[Change, ...]:
    """No R: E alone moves under the axis limits."""
    return tuple(change for change in _marlin_m204(command) if change.name != "retract_acceleration")


def _klipper_m204(command: Parameters) -> tuple[Change, ...]:
    if command.number("S") is not None:
        return _positive(command, "S", "acceleration")
    printing, travel = command.number("P"), command.number("T")
    if printing is None or travel is None:
        return ()
    return _positive(command, "P" if printing <= travel else "T", "acceleration")


def _klipper_velocity_limit(command: Parameters) -> tuple[Change, ...]:
    ratio = _positive(command, "MINIMUM_CRUISE_RATIO", "minimum_cruise_ratio", zero=True)
    return (
        _positive(command, "VELOCITY", "velocity")
        + _positive(command, "ACCEL", "acceleration")
        + _positive(command, "SQUARE_CORNER_VELOCITY", "square_corner_velocity", zero=True)
        + (ratio or _positive(command, "ACCEL_TO_DECEL", "accel_to_decel"))
    )


LIMIT_COMMANDS: dict[str, dict[str, Callable[[Parameters], tuple[Change, ...]]]] = {
    "marlin": {
        "M201": _per_axis("axis_acceleration"),
        "M203": _per_axis("axis_velocity"),
        "M204": _marlin_m204,
        "M205": _marlin_m205,
    },
    "klipper": {"M204": _klipper_m204, "SET_VELOCITY_LIMIT": _klipper_velocity_limit},
    "reprapfirmware": {
        "M201": _per_axis("axis_acceleration"),
        "M203": _reprap_m203,
        "M204": _reprap_m204,
        "M205": _per_axis("jerk"),
        "M566": _per_axis("jerk", S_PER_MIN),
    },
}
