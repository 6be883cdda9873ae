"""Command and measurement side by side, in any table: columns go by their names, or as the user chooses them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fbfcli.plant.column_names import Column, chosen, of_role
from fbfcli.plant.recording import ReadOptions, Recording
from fbfcli.plant.sensor import UNITS, oddities
from fbfcli.plant.text_table import TextTable
from fbfcli.plant.time_base import TimeBase, counted, time_base

LENGTH_UNITS = {"mm": 1.0, "m": 1e3, "mm/s": 1.0}


def pair(table: TextTable, columns: Sequence[Column], options: ReadOptions) -> Recording:
    """One capture with its command. Measured columns are those of the same quantity as the command."""
    command = _one(table, columns, options.command, "command", "--command")
    clock = _clock(table, columns, options)
    which = _measured(table, columns, options, command)
    kinds = {columns[i].quantity for i in (command, *which)} - {""}
    if len(kinds) > 1:
        raise table.error(f"command and measurement are of different kinds: {' and '.join(sorted(kinds))}",
                          remedy="choose two of the same kind with --command and --measured")  # fmt: skip
    quantity = next(iter(kinds), "acceleration")
    axis = columns[command].axis or next((columns[i].axis for i in which if columns[i].axis), None)
    names = tuple(columns[i].axis or axis or "x" for i in which)
    rows = table.values[clock.keep]
    measured = np.column_stack([rows[:, i] * _scale(columns[i], options, quantity) for i in which])
    notes = (*table.notes, *clock.notes)
    if quantity == "acceleration":
        notes += oddities(measured, names, table.line[clock.keep])
    command_values = rows[:, command] * _scale(columns[command], options, quantity)
    if not np.ptp(command_values):
        raise table.error(f"the command, column {command + 1}, is constant", 0, "choose another with --command")
    return Recording("pair", table.name, clock.fs, clock.t, measured, names, command_values, axis, quantity=quantity,
                     notes=notes)  # fmt: skip


def _clock(table: TextTable, columns: Sequence[Column], options: ReadOptions) -> TimeBase:
    times = of_role(columns, "time")
    if options.time is not None:
        times = [chosen(table, columns, options.time, "--time")]
    if options.rate is not None and options.time is None:
        return counted(len(table.line), options.rate, table)
    if not times:
        raise table.error("no column of times", remedy="choose it with --time, or give --rate")
    return time_base(table.values[:, times[0]], columns[times[0]].unit or None, table)


def _one(table: TextTable, columns: Sequence[Column], wanted: str | None, role: str, option: str) -> int:
    if wanted is not None:
        return chosen(table, columns, wanted, option)
    found = of_role(columns, role)
    if len(found) != 1:
        many = "several columns look" if found else "no column looks"
        raise table.error(f"{many} like the {role}", remedy=f"choose it with {option}")
    return found[0]


def _measured(table: TextTable, columns: Sequence[Column], options: ReadOptions, command: int) -> list[int]:
    if options.measured is not None:
        return [chosen(table, columns, name.strip(), "--measured") for name in options.measured.split(",")]
    kind = columns[command].quantity
    found = [i for i in of_role(columns, "measured") if not kind or columns[i].quantity in ("", kind)]
    if not found:
        raise table.error("no column looks like the measurement", remedy="choose it with --measured")
    return found


def _scale(one: Column, options: ReadOptions, quantity: str) -> float:
    if quantity == "acceleration":
        return UNITS.get(options.unit or one.unit, 1.0)
    return LENGTH_UNITS.get(one.unit, 1.0)
