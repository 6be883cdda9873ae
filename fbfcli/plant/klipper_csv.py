"""Klipper's two CSV files: raw_data_*.csv with times, resonances_*.csv and calibration_data_*.csv with spectra.

Columns go by their names: Kalico puts others between them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from fbfcli.plant.column_names import Column, of_role
from fbfcli.plant.recording import PowerSpectrum, Recording
from fbfcli.plant.sensor import oddities
from fbfcli.plant.text_table import TextTable
from fbfcli.plant.time_base import time_base

SHAPER = re.compile(r"(\w+)\(([\d.]+)\)")  # zv(52.6)


def klipper_raw(table: TextTable, columns: Sequence[Column]) -> Recording:
    """raw_data_*.csv: accelerations [mm/s^2] against the time of the host [s].

    Klipper names an axis in the file's name only, so `axis` is None.
    """
    clock = time_base(table.values[:, of_role(columns, "time")[0]], "s", table)
    which = of_role(columns, "measured")
    names = tuple(columns[i].axis for i in which)
    measured = table.values[clock.keep][:, which]
    notes = (*table.notes, *clock.notes, *oddities(measured, names, table.line[clock.keep]))
    return Recording("klipper raw", table.name, clock.fs, clock.t, measured, names, notes=notes)


def klipper_psd(table: TextTable, columns: Sequence[Column]) -> PowerSpectrum:
    """Spectral densities; the columns named zv(52.6) and so on tell the shapers that Klipper fitted."""
    which = of_role(columns, "psd")
    frequency = table.values[:, of_role(columns, "frequency")[0]]
    power = table.values[:, which]
    for row in np.flatnonzero(np.diff(frequency) <= 0)[:1]:
        raise table.error("frequencies do not rise", int(row) + 1, "one spectrum per file")
    for row in np.flatnonzero((power < 0).any(axis=1))[:1]:
        raise table.error("a power is negative", int(row), "mend the line")
    if not power.any():
        raise table.error("all powers are zero", 0, "the capture failed; record again")
    found = [SHAPER.fullmatch(one.name.strip()) for one in columns]
    shapers = tuple((match[1], float(match[2])) for match in found if match)
    return PowerSpectrum(table.name, frequency, power, tuple(columns[i].axis for i in which), shapers, table.notes)
