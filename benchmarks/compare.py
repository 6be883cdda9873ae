"""Compare all methods on sliced parts: `python benchmarks/compare.py`; `--write` puts it in docs/simulate.md.

What `fbf simulate` tells, on every fourth layer: contour error RMS while extruding, on the machine as modelled and on
machines whose frequencies are off (the RMS of both directions); and print time against error.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from page import program
from robustness import PARTS, layers

from fbfcli.cli.lookup import bundled
from fbfcli.control.design import METHODS
from fbfcli.errors import ModelError
from fbfcli.gcode.scan import chunks
from fbfcli.pipeline import Settings
from fbfcli.pipeline.simulate import FIRMWARE, Wanted, simulate
from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.summary import clock
from fbfcli.printer import Printer

ROOT = Path(__file__).parents[1]
PAGE, COMMAND = ROOT / "docs" / "simulate.md", "benchmarks/compare.py --write"
PRINTERS = ("synthetic_bed_slinger", "taz6")
IN_FIRMWARE = (FIRMWARE + "mzv", FIRMWARE + "ei")
ALL = (METHODS[0], *IN_FIRMWARE, *METHODS[1:])
MISMATCHES = (0.05, 0.10)
ACCELERATION = 5000.0  # mm/s^2
SWEEP = (1000.0, 3000.0, 5000.0, 10000.0)
SWEPT, SWEPT_PART = ("none", FIRMWARE + "mzv", "mzv", "lpfbs", "contour"), "ringing_tower"


def simulated(part: str, printer: Printer, wanted: Wanted) -> Simulation:
    """A part of sample_gcode."""
    text = layers((ROOT / "sample_gcode" / f"{part}.gcode").read_bytes())
    return simulate(lambda: chunks(io.BytesIO(text)), printer, Settings(), wanted)


def errors(one: Simulated) -> list[float]:
    """Contour error RMS as modelled, and for each mismatch over both directions [um]."""
    rms = [figures.total.contour.rms for figures in one.figures]
    return [rms[0], *(float(np.hypot(*rms[1 + 2 * k : 3 + 2 * k]) / 2**0.5) for k in range(len(MISMATCHES)))]


def method_rows(name: str, printer: Printer) -> list[str]:
    """The table of one printer."""
    columns = [f"{part} {off}" for part in PARTS for off in ("", *(f"±{100 * q:.0f} %" for q in MISMATCHES))]
    lines = [f"### {printer.name}: contour error RMS, um", "",
             "| method | print time | " + " | ".join(column.strip() for column in columns) + " |",
             "|---" * (2 + len(columns)) + "|"]  # fmt: skip
    refused = []
    for method in ALL:
        wanted = Wanted(methods=(method,), accelerations=(ACCELERATION,), mismatches=MISMATCHES)
        try:
            found = [simulated(part, printer, wanted).results[0] for part in PARTS]
        except ModelError:
            refused.append(f"`{method}`")
            continue
        made = ", ".join(f"{axis} {one.frequency:.1f} Hz" for axis, one in zip("xy", found[0].made_for, strict=False))
        cells = [f"{error:.1f}" for one in found for error in errors(one)]
        time = clock(sum(one.time for one in found))
        lines.append(f"| `{method}`{f' ({made})' if made else ''} | {time} | {' | '.join(cells)} |")
    return [*lines, "", *([f"Not applicable to this model: {', '.join(refused)}.", ""] if refused else [])]


def sweep_rows(printer: Printer) -> list[str]:
    """Print time against error."""
    told = simulated(SWEPT_PART, printer, Wanted(methods=SWEPT, accelerations=SWEEP))
    lines = [f"### {printer.name}: print time against contour error of {SWEPT_PART}, um (RMS / 99 %)", "",
             "| mm/s² | " + " | ".join(f"`{method}`" for method in SWEPT) + " |",
             "|---" * (1 + len(SWEPT)) + "|"]  # fmt: skip
    for acceleration in SWEEP:
        cells = [
            f"{clock(one.time)}: {error.rms:.1f} / {error.p99:.0f}"
            for one in told.results
            if one.acceleration == acceleration
            for error in [one.figures[0].total.contour]
        ]
        lines.append(f"| {acceleration:.0f} | {' | '.join(cells)} |")
    return lines


def tables() -> str:
    """All of them."""
    lines = []
    for name in PRINTERS:
        printer = bundled()[name]
        lines += [*method_rows(name, printer), *sweep_rows(printer), ""]
    return "\n".join(lines).rstrip()


if __name__ == "__main__":
    program(__doc__, PAGE, COMMAND, tables)
