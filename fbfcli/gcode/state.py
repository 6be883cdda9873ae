"""What a firmware remembers between two lines of a file."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

from fbfcli.printer import Axis, Four, Limits, Printer


@dataclass(frozen=True)
class State:
    """The modal state between two chunks of a file.

    logical      : the file's own coordinates X, Y, Z, E [mm]
    offset       : machine - logical; of E: cumulative - logical, so that resets do not show [mm]
    known        : X and Y have been commanded since the machine last moved by itself
    home         : where homing puts X, Y, Z [mm]
    g91, m83     : relative coordinates, relative extrusion, as the firmware keeps them
    inch, plane  : G20, and 17, 18 or 19
    feed         : F as written, nan before the first; `feed_unit` [mm] is the unit it was written in
    speed_factor : M220
    motion_mode  : 0, 1, 2, 3 or 5
    limits       : every set of limits met so far; `in_force` is the index of the present one
    resting      : something brought the machine to rest after the last move
    warned       : warnings already given
    """

    logical: Four
    offset: Four
    known: tuple[bool, bool]
    home: tuple[float, float, float]
    limits: tuple[Limits, ...]
    in_force: int = 0
    g91: bool = False
    m83: bool = False
    inch: bool = False
    plane: int = 17
    feed: float = nan
    feed_unit: float = 1.0
    speed_factor: float = 1.0
    motion_mode: int = 1
    resting: bool = True
    warned: frozenset[str] = frozenset()


def initial_state(printer: Printer) -> State:
    """State at power-on: nothing homed, absolute coordinates, millimetres."""
    x, y, z = (_home(axis) for axis in printer.axes)
    return State((x, y, z, 0.0), (0.0,) * 4, (False, False), (x, y, z), (printer.limits,))


def _home(axis: Axis) -> float:
    """0 where the axis can reach it, else the nearest end of its travel [mm]."""
    low, high = axis.travel
    return min(max(0.0, low), high)
