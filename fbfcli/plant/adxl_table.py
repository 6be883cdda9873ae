"""Accelerations alone, as adxl345spi and its kin write them: x, y, z with times or at a known rate.

adxl345spi writes time [s] and g. py3dpaxxel writes sequence, sample and mg, and its last line tells the setting
of the sensor: # {'rate': 'ODR3200', 'range': 'G4', 'scale': 'FULL_RES_4MG_LSB'}.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from fbfcli.plant.column_names import Column, of_role
from fbfcli.plant.recording import ReadOptions, Recording
from fbfcli.plant.sensor import UNITS, oddities, unit_by_gravity
from fbfcli.plant.text_table import TextTable
from fbfcli.plant.time_base import TimeBase, counted, time_base

RATE = re.compile(r"ODR_?(\d+)")
LOOSE = 0.05  # by which the oscillator of an ADXL345 may be off, of its nominal rate


def adxl(table: TextTable, columns: Sequence[Column], options: ReadOptions) -> Recording:
    """One capture. The unit is the one named, else that in which the sensor shows one g."""
    which = of_role(columns, "measured")
    clock = _clock(table, columns, options)
    values = table.values[clock.keep][:, which]
    named = next((columns[i].unit for i in which if columns[i].unit in UNITS), None)
    unit = options.unit or named or (unit_by_gravity(values) if len(which) == 3 else None)
    if unit is None:
        raise table.error("the unit of the accelerations is not known", 0, "give --unit, such as --unit g")
    measured = values * UNITS[unit]
    names = tuple(columns[i].axis for i in which)
    told = () if options.unit or named else (f"accelerations are taken to be in {unit}: gravity shows so",)
    notes = (*table.notes, *clock.notes, *told, *oddities(measured, names, table.line[clock.keep]))
    return Recording("adxl", table.name, clock.fs, clock.t, measured, names, notes=notes)


def _clock(table: TextTable, columns: Sequence[Column], options: ReadOptions) -> TimeBase:
    times = of_role(columns, "time")
    if times and options.rate is None:
        return time_base(table.values[:, times[0]], columns[times[0]].unit or None, table)
    told = next((float(match[1]) for match in map(RATE.search, table.comments) if match), None)
    fs = options.rate or told
    if fs is None:
        raise table.error("neither times nor a rate", remedy="give --rate")
    clock = counted(len(table.line), fs, table)
    note = f"the rate is the nominal {fs:g} Hz, good to {100 * LOOSE:.0f} %: frequencies are no better"
    return clock if options.rate else TimeBase(clock.fs, clock.t, clock.keep, (note,))
