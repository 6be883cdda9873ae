"""Compare all methods on the ringing tower: `python benchmarks/methods.py`; `--write` puts it in docs/methods.md."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from executed import executed
from page import program

from fbfcli.cli.lookup import bundled
from fbfcli.control.design import METHODS
from fbfcli.control.limits import peaks
from fbfcli.errors import ModelError
from fbfcli.pipeline import Settings, Summary
from fbfcli.pipeline.summary import clock
from fbfcli.printer import Printer

ROOT = Path(__file__).parents[1]
PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
PAGE = ROOT / "docs" / "methods.md"
COMMAND = "benchmarks/methods.py --write"
ACCELERATION = 5000.0  # mm/s^2; the file prints at 200 mm/s
PRINTERS = (("taz6", None), ("taz6", 300.0), ("synthetic_bed_slinger", None))  # name, segments/s if not the profile's


@dataclass(frozen=True)
class Result:
    """One method on one printer; `peak` is the largest commanded |u''| of an axis over one sample [mm/s^2]."""

    summary: Summary
    peak: float

    HEAD = (
        "| method | contour error RMS | 99 % | max | print time | chord error RMS | segments/s | peak acceleration |",
        "|---|---|---|---|---|---|---|---|",
    )

    @property
    def row(self) -> str:
        """One line of the table."""
        told = self.summary
        error = told.contour_after
        cells = (f"`{told.method}`", f"{error.rms:.1f}", f"{error.p99:.0f}", f"{error.max:.0f}", clock(told.time),
                 f"{told.chord_error.rms:.1f}", f"{told.segments_per_second:.0f}",
                 f"{self.peak / 1000:.1f}")  # fmt: skip
        return f"| {' | '.join(cells)} |"


def result(text: bytes, printer: Printer, method: str, segments: float | None) -> Result:
    """Compensate the text by a method; what the written file does, and what was commanded."""
    settings = Settings(method=method, acceleration=ACCELERATION, segments_per_second=segments)
    done = executed(text, printer, settings)
    return Result(done.summary, float(np.max(peaks(done.command, done.begin, settings.dt)[1])))


def table(text: bytes, printer: Printer, segments: float | None) -> str:
    """All methods on one printer, and how much better `lpfbs` is than nothing."""
    results, refused = {}, []
    for method in METHODS:
        try:
            results[method] = result(text, printer, method, segments)
        except ModelError:
            refused.append(f"`{method}`")
    none, lpfbs, fbf = (results[method].summary.contour_after.rms for method in ("none", "lpfbs", "fbf"))
    better, apart = none / lpfbs, abs(lpfbs / fbf - 1.0)
    budget = results["none"].summary.budget
    lines = [f"### {printer.name}, at most {budget:.0f} segments per second", "", *Result.HEAD]
    lines += [each.row for each in results.values()]
    lines += ["", f"`lpfbs` is {better:.1f} times below `none`, and {apart:.1%} from `fbf`."]
    lines += [f"Not applicable to this model: {', '.join(refused)}."] if refused else []
    return "\n".join(lines)


def tables() -> str:
    """Of each printer."""
    text, printers = PART.read_bytes(), bundled()
    return "\n\n".join(table(text, printers[name], segments) for name, segments in PRINTERS)


if __name__ == "__main__":
    program(__doc__, PAGE, COMMAND, tables)
