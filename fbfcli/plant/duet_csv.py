"""RepRapFirmware's M956: Sample,X,Y,Z in g without times; the last line tells the rate.

https://docs.duet3d.com/User_manual/Reference/Gcodes#m956-collect-accelerometer-data-and-write-to-file
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.column_names import Column, of_role
from fbfcli.plant.recording import ReadOptions, Recording
from fbfcli.plant.sensor import UNITS, oddities
from fbfcli.plant.text_table import TextTable
from fbfcli.plant.time_base import counted

RATE = re.compile(r"Rate\s+([\d.]+)\s*,?\s*overflows\s+(\d+)", re.IGNORECASE)
FAILED = re.compile(r"Failed to .*", re.IGNORECASE)


def duet(table: TextTable, columns: Sequence[Column], options: ReadOptions) -> Recording:
    """One capture. The first sample is left out: it was taken before the filter of the sensor had settled."""
    notes = list(table.notes)
    rate, overflows = _footer(table)
    if options.rate or rate:
        fs = options.rate or rate
    else:
        raise table.error("no line tells the rate", len(table.line) - 1, "the file is cut off; give --rate")
    if overflows:
        notes.append(f"the sensor's buffer overflowed {overflows} times: samples are missing, where is not known")
    which = of_role(columns, "measured")
    names = tuple(columns[i].axis for i in which)
    count = table.values[1:, of_role(columns, "count")[0]]
    lost = int(np.sum(np.diff(count) - 1)) if len(count) else 0
    if (np.diff(count) <= 0).any():
        row = int(np.flatnonzero(np.diff(count) <= 0)[0]) + 2
        raise table.error("sample numbers do not rise", row, "two captures in one file? Split them")
    if lost:
        notes.append(f"{lost} sample numbers are missing")
    measured = table.values[1:, which] * UNITS[options.unit or "g"]
    clock = counted(len(measured), fs, table)
    t = (count - count[0]) / fs if lost else clock.t
    notes += oddities(measured, names, table.line[1:])
    return Recording("duet", table.name, fs, t, measured, names, notes=tuple(notes))


def failed_capture(text: str, name: str) -> None:
    """Refuse a file in which RepRapFirmware tells that the capture failed."""
    for number, row in enumerate(text.splitlines()[:20], 1):
        if FAILED.match(row.strip()):
            raise RecordingError("the capture failed", file=name, line=number, text=row, remedy="check M955, then M956")


def _footer(table: TextTable) -> tuple[float, int]:
    """Rate [Hz], 0 where it is not told, and overflows."""
    for number, row in table.footer:
        match = RATE.search(row)
        if match:
            if float(match[1]) <= 0:
                raise RecordingError("the rate is not positive", file=table.name, line=number, text=row,
                                     remedy="the capture failed; record again")  # fmt: skip
            return float(match[1]), int(match[2])
        if not row.startswith("#"):
            raise RecordingError("not a sample, nor the rate", file=table.name, line=number, text=row,
                                 remedy="cut the line out")  # fmt: skip
    return 0.0, 0
