"""Measure the motors of `fbf simulate`: `python benchmarks/bench_motors.py [--write]`.

The ringing tower on every bundled printer with motors, as it is written and compensated: what they are asked for, how
much of the print is integrated, and what that costs; and the same with everything integrated, which must agree.
`--write` puts the table into docs/motors.md.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from page import program

from fbfcli.cli.lookup import bundled
from fbfcli.gcode.scan import chunks
from fbfcli.pipeline.settings import Settings
from fbfcli.pipeline.simulate import Wanted, simulate
from fbfcli.printer import Printer
from fbfcli.verify.motors_told import MotorsTold
from fbfcli.verify.passage import Passage
from fbfcli.verify.stepper import NEEDED, Motors

ROOT = Path(__file__).parents[1]
PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
PAGE, COMMAND = ROOT / "docs" / "motors.md", "benchmarks/bench_motors.py --write"
METHODS = ("none", "contour")
S_PER_HOUR = 3600.0
HEAD = (
    "| printer | method | motor | torque taken at most | rotor behind by | of the print integrated | CPU s an hour, "
    "all motors | everything integrated: rotor behind by | CPU s an hour, all motors |",
    "|---|---|---|---|---|---|---|---|---|",
)


class Keeping:
    """Keeps every passage of one method."""

    def __init__(self) -> None:
        self.kept: list[Passage] = []

    def begin(self, name: str, features: Sequence[str]) -> None:
        pass

    def add(self, name: str, passage: Passage) -> None:
        self.kept.append(passage)

    def segments(self, name: str, starts: np.ndarray) -> None:
        pass

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        pass


@dataclass(frozen=True)
class Measured:
    """What motors were told, and CPU seconds for an hour of print."""

    told: MotorsTold
    cpu_s: float


def measure(printer: Printer, passages: Sequence[Passage], needed: float) -> Measured:
    """The motors under passages that are there already."""
    dt = passages[0].execution.dt
    begin = time.process_time()
    motors = Motors(printer, dt, needed)
    for passage in passages:
        motors.add(passage)
    told = motors.figures()
    return Measured(told, (time.process_time() - begin) * S_PER_HOUR / (dt * sum(map(len, passages))))


def rows(name: str, printer: Printer) -> Iterator[str]:
    """Lines of the table of one printer."""
    for method in METHODS:
        keeping = Keeping()
        wanted = Wanted(methods=(method,))
        with PART.open("rb") as file:
            simulate(lambda file=file: chunks(file), printer, Settings(patch_times=False), wanted, watchers=[keeping])
        picked, whole = (measure(printer, keeping.kept, needed) for needed in (NEEDED, 0.0))
        assert not picked.told.lost and not whole.told.lost
        for a, b in zip(picked.told.motors, whole.told.motors, strict=True):
            cells = (f"`{name}`", method, a.name, f"{100 * a.share:.0f} %", f"{a.angle_um:.0f} um",
                     f"{100 * a.integrated:.1f} %", f"{picked.cpu_s:.1f}", f"{b.angle_um:.0f} um",
                     f"{whole.cpu_s:.0f}")  # fmt: skip
            yield f"| {' | '.join(cells)} |"


def table() -> str:
    """Of every bundled printer that has motors."""
    driven = {name: printer for name, printer in bundled().items() if any(axis.motor for axis in printer.axes)}
    return "\n".join([*HEAD, *(row for name, printer in driven.items() for row in rows(name, printer))])


if __name__ == "__main__":
    program(__doc__, PAGE, COMMAND, table)
