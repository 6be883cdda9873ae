"""Frequency responses that were measured already: magnitude and phase, or real and imaginary part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fbfcli.plant.column_names import Column, of_role
from fbfcli.plant.recording import ResponseTable
from fbfcli.plant.text_table import TextTable

TURN = 2 * np.pi
PAST_A_TURN = 7.0  # a phase beyond this is in degrees: no machine turns so far in radians at its first frequencies


def response_table(table: TextTable, columns: Sequence[Column]) -> ResponseTable:
    """The response against frequency. RecordingError where frequencies do not rise or are missing."""
    at = of_role(columns, "frequency")[0]
    frequency = table.values[:, at] / (TURN if columns[at].unit == "rad/s" or "omega" in columns[at].name else 1.0)
    for row in np.flatnonzero(np.diff(frequency) <= 0)[:1]:
        raise table.error("frequencies do not rise", int(row) + 1, "sort the table; one response per file")
    real, imaginary = of_role(columns, "real"), of_role(columns, "imaginary")
    size, phase = of_role(columns, "magnitude"), of_role(columns, "phase")
    notes: list[str] = list(table.notes)
    has_phase = bool((real and imaginary) or phase)
    if real and imaginary:
        response = table.values[:, real[0]] + 1j * table.values[:, imaginary[0]]
    elif size:
        magnitude = _magnitude(table, columns[size[0]], size[0], notes)
        angle = _radians(table, columns[phase[0]], phase[0], notes) if phase else np.zeros(len(magnitude))
        response = magnitude * np.exp(1j * angle)
    else:
        raise table.error("no magnitude, and no real and imaginary part", remedy="name the columns, such as "
                          "frequency,magnitude_db,phase_deg")  # fmt: skip
    coherence = of_role(columns, "coherence")
    axis = next((columns[i].axis for i in (*size, *real) if columns[i].axis in ("x", "y")), None)
    return ResponseTable(table.name, frequency, response, table.values[:, coherence[0]] if coherence else None,
                         has_phase, axis, tuple(notes))  # fmt: skip


def _magnitude(table: TextTable, one: Column, at: int, notes: list[str]) -> np.ndarray:
    """Linear. Without a unit, negative values can only be dB."""
    values = table.values[:, at]
    if one.unit == "db" or "db" in one.name.lower() or (not one.unit and values.min() < 0):
        if "db" not in one.name.lower():
            notes.append("magnitudes are taken to be in dB: some are negative")
        return np.asarray(10 ** (values / 20))
    for row in np.flatnonzero(values < 0)[:1]:
        raise table.error("a magnitude is negative", int(row), "is it in dB? Say so in the column's name")
    return values


def _radians(table: TextTable, one: Column, at: int, notes: list[str]) -> np.ndarray:
    values = table.values[:, at]
    if one.unit == "deg" or (not one.unit and np.abs(values).max() > PAST_A_TURN):
        if one.unit != "deg":
            notes.append("phases are taken to be in degrees")
        return np.radians(values)
    return values
