"""Recordings are read by their content, whatever they are called."""

from __future__ import annotations

from dataclasses import replace

from fbfcli.errors import RecordingError
from fbfcli.plant.adxl_table import adxl
from fbfcli.plant.column_names import Column, columns_of, of_role
from fbfcli.plant.duet_csv import duet, failed_capture
from fbfcli.plant.frf_table import response_table
from fbfcli.plant.klipper_csv import klipper_psd, klipper_raw
from fbfcli.plant.paired_csv import pair
from fbfcli.plant.recording import Read, ReadOptions
from fbfcli.plant.sensor import unit_by_gravity
from fbfcli.plant.text_table import TextTable, read_table, text_of
from fbfcli.plant.ulendo_json import ulendo

UNNAMED = "time,accel_x,accel_y,accel_z"  # four columns without names are these, where gravity shows in mm/s^2


def read_recordings(data: bytes, name: str, options: ReadOptions | None = None) -> tuple[Read, ...]:
    """Everything that one file holds. Raises RecordingError: file, line, what is wrong and the remedy."""
    how = options or ReadOptions()
    text = text_of(data, name)
    if text.lstrip()[:1] in ("{", "["):
        return (ulendo(text, name),)
    failed_capture(text, name)
    table = _named(read_table(text, name))
    return (_of_table(table, columns_of(table), how),)


def _of_table(table: TextTable, columns: tuple[Column, ...], how: ReadOptions) -> Read:
    """The kind of a table by what its columns are; what the user chose comes first."""
    roles = {one.role for one in columns}
    if how.command is not None:
        return pair(table, columns, how)
    if {"frequency", "psd"} <= roles:
        return klipper_psd(table, columns)
    if "frequency" in roles and roles & {"magnitude", "real", "phase"}:
        return response_table(table, columns)
    if "command" in roles:
        return pair(table, columns, how)
    accelerations = [columns[i] for i in of_role(columns, "measured") if columns[i].axis]
    if "count" in roles and "time" not in roles and accelerations and "seq" not in table.header:
        return duet(table, columns, how)
    if "time" in roles and len(accelerations) == 3 and all(one.name.startswith("accel_") for one in accelerations):
        return klipper_raw(table, columns)
    if accelerations:
        return adxl(table, columns, how)
    has = f"columns {', '.join(table.header)}" if table.header else f"{table.values.shape[1]} columns without names"
    raise RecordingError(f"{has}: no recording that is known", file=table.name,
                         line=int(table.line[0]) - bool(table.header),
                         remedy="choose columns with --time, --command and --measured")  # fmt: skip


def _named(table: TextTable) -> TextTable:
    """A table with Klipper's names where it has none and looks like Klipper's."""
    if table.header or table.values.shape[1] != 4 or unit_by_gravity(table.values[:, 1:]) != "mm/s^2":
        return table
    note = "columns have no names: taken to be time and accelerations of x, y, z"
    return replace(table, header=tuple(UNNAMED.split(",")), notes=(*table.notes, note))
