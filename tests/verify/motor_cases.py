"""Motors, and prints that move them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from fbfcli.printer import Axis, Limits, Load, Motor, Printer
from fbfcli.verify.execution import Execution
from fbfcli.verify.motors_told import MotorsTold
from fbfcli.verify.passage import Passage
from fbfcli.verify.stepper import NEEDED, Motors

DT = 1e-3
MOTOR = Motor("test", 200, 0.59, 2.0, 1.4, 3e-3, 82e-7, 24.0, 1.0, 16, 40.0, interpolation=True)
LOAD = Load(0.5, friction=3.0)
MIDDLE = 100.0  # mm: where prints begin


def printer(kinematics: str = "cartesian", motor: Motor | None = MOTOR, load: Load | None = LOAD) -> Printer:
    """X, on a CoreXY also Y, and on a delta Z too have this motor."""
    driven = {"cartesian": "X", "corexy": "XY", "delta": "XYZ"}[kinematics]
    axes = [Axis(name, (0.0, 300.0), 80.0, motor=motor, load=load) if name in driven else Axis(name, (0.0, 300.0), 80.0)
            for name in "XYZ"]  # fmt: skip
    return Printer("test", "", "klipper", kinematics, (axes[0], axes[1], axes[2]), Limits(), 1000.0,
                   delta_radius=150.0, arm_length=300.0)  # fmt: skip


def execution(x: np.ndarray, line: np.ndarray | None = None, first: int = 0, goes_on: bool = False) -> Execution:
    """One stretch, or what follows of it from sample `first` on; x : ndarray, shape (n, 3)."""
    n, none = len(x), np.zeros(len(x), dtype=np.int64)
    begin = np.zeros(0 if first else 1, dtype=np.int64)
    lines = np.arange(first, first + n) if line is None else line
    return Execution(
        DT, begin, begin, goes_on, (first + np.arange(n)) * DT, lines, none, none, x[:, :2], x[:, :2],
        np.column_stack([x, none]), none.astype(bool),
    )  # fmt: skip


def rigid(what: Execution) -> Passage:
    """The passage of a machine that does not vibrate."""
    none = np.zeros(len(what))
    return Passage(what, what.motion[:, :2], none, none, none, none)


def there(distance: float, speed: float, acceleration: float, rest: int = 100) -> np.ndarray:
    """Positions of one move from a standstill to a standstill, with samples of rest around it, shape (n,) [mm]."""
    ramp = speed / acceleration
    whole = distance / speed + ramp
    t = np.arange(0.0, whole + DT, DT)
    rising, falling = np.minimum(t, ramp), np.clip(t - (whole - ramp), 0.0, ramp)
    x = 0.5 * acceleration * rising**2 + speed * (t - rising) - 0.5 * acceleration * falling**2
    return MIDDLE + np.concatenate([np.zeros(rest), np.minimum(x, distance), np.full(rest, distance)])


def along(axis: int, move: np.ndarray) -> np.ndarray:
    """X Y Z of a move along one axis, shape (n, 3)."""
    x = np.full((len(move), 3), MIDDLE)
    x[:, 2] = 1.0
    x[:, axis] += move - MIDDLE
    return x


def told(x: np.ndarray, machine: Printer, needed: float = NEEDED, pieces: int = 1) -> MotorsTold:
    """What the motors are asked for by a rigid machine's print that arrives in pieces."""
    motors = Motors(machine, DT, needed)
    cuts = np.linspace(0, len(x), pieces + 1).astype(int)
    for a, b in pairwise(cuts):
        motors.add(rigid(execution(x[a:b], first=int(a), goes_on=b < len(x))))
    return motors.figures()
