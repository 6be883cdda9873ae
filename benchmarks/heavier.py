"""A print that makes its bed heavier: models at two masses against one model throughout.

    python benchmarks/heavier.py            the table
    python benchmarks/heavier.py --write    puts it into docs/robustness.md

The Y resonance falls from 40 to 32 Hz while the ringing tower is printed. The files are executed by the planner model,
and the machine is simulated with its plant changing in steps of 1/200 of the mass, unlike those of the compensation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
from executed import Executed, executed
from page import program
from robustness import UM, one

from fbfcli.cli.lookup import bundled
from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.scan import scan
from fbfcli.motion.moves import E
from fbfcli.pipeline import Settings
from fbfcli.plant.model import plant_of
from fbfcli.printer import Place, Printer
from fbfcli.verify.simulate import BA, Nozzle

ROOT = Path(__file__).parents[1]
PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
PAGE, COMMAND = ROOT / "docs" / "robustness.md", "benchmarks/heavier.py --write"
EMPTY, FULL, X = 40.0, 32.0, 45.0  # Hz
ACCELERATION = 5000.0
STEPS = 200
METHODS = ("mzv", "lpfbs", "contour")


def printers(kg: float) -> dict[str, Printer]:
    """The same machine with what is said of Y: one model, and models at no mass and at that of the whole print."""
    base = bundled()["synthetic_bed_slinger"]
    x, y, z = base.axes
    wide = {"command_acceleration": 1e5, "command_velocity": 600.0}
    x, y = replace(x, model=one(X), **wide), replace(y, model=one(EMPTY), **wide)
    at = (Place(one(EMPTY), mass=0.0), Place(one(FULL), mass=kg))
    middle = replace(y, model=one((0.5 / EMPTY**2 + 0.5 / FULL**2) ** -0.5))
    return {
        f"one model, {EMPTY:.0f} Hz": replace(base, axes=(x, y, z)),
        f"one model, {middle.model.modes[0].frequency:.1f} Hz": replace(base, axes=(x, middle, z)),
        "models at both masses": replace(base, axes=(x, replace(y, at=at), z)),
    }


def filament(printer: Printer, text: bytes) -> float:
    """What the print pushes in all [mm]."""
    moves = interpret(scan(text), initial_state(printer), printer)[0].moves
    return float(moves.start[-1, E] + moves.delta[-1, E])


def error(done: Executed, pushed: float) -> float:
    """RMS error across the path of the machine that gets heavier [um]: 1 / f^2 rises with what has been pushed."""
    ratio = (EMPTY / FULL) ** 2 - 1.0
    x = plant_of(one(X), 1e-3, "x")

    def plants(step: int) -> Sequence[BA]:
        y = plant_of(one(EMPTY / np.sqrt(1.0 + ratio * step / STEPS)), 1e-3, "y")
        return (x.b, x.a), (y.b, y.a)

    step = np.rint(STEPS * np.clip(done.motion[:, E] / pushed, 0.0, 1.0)).astype(np.int64)
    nozzle = Nozzle(plants).follow(done.motion[:, :2], done.begin, done.rest, np.maximum.accumulate(step))
    return UM * done.contour(nozzle)


def table() -> str:
    text = PART.read_bytes()
    base = bundled()["synthetic_bed_slinger"]
    pushed = filament(base, text)
    kg = pushed * pi * (base.filament_diameter / 2) ** 2 * base.filament_density
    lines = ["| what the profile says of Y | " + " | ".join(METHODS) + " |", "|---" * (1 + len(METHODS)) + "|"]
    for words, printer in printers(kg).items():
        done = (executed(text, printer, Settings(method=name, acceleration=ACCELERATION)) for name in METHODS)
        lines.append(f"| {words} | {' | '.join(f'{error(each, pushed):.1f}' for each in done)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    program(__doc__, PAGE, COMMAND, table)
