"""What the name of a column says: its role, axis, quantity and unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from fbfcli.plant.text_table import TextTable

ROLES = {  # words in a name, and the role that they give it; the first role that fits is taken
    "psd": {"psd"},
    "time": {"time", "t", "timestamp", "seconds", "timestamps"},
    "coherence": {"coherence", "coh", "gamma2"},
    "frequency": {"freq", "frequency", "f", "hz", "omega", "freqs"},
    "phase": {"phase", "angle", "arg", "phi"},
    "magnitude": {"magnitude", "mag", "gain", "amplitude", "abs", "db"},
    "real": {"real", "re"},
    "imaginary": {"imag", "imaginary", "im"},
    "command": {"cmd", "command", "commanded", "ref", "reference", "demand", "setpoint", "target", "desired", "input",
                "u", "excitation"},
    "measured": {"meas", "measured", "actual", "output", "response", "sensor", "accel", "acc", "acceleration",
                 "accelerometer", "encoder", "theta", "x", "y", "z", "ax", "ay", "az", "accx", "accy", "accz"},
    "count": {"sample", "seq", "n", "index", "#", "samples"},
}  # fmt: skip
AXES = {"x": "x", "y": "y", "z": "z", "ax": "x", "ay": "y", "az": "z", "accx": "x", "accy": "y", "accz": "z",
        "xyz": "xyz"}  # fmt: skip
QUANTITIES = {"acceleration": {"accel", "acc", "acceleration", "accelerometer", "ax", "ay", "az", "accx", "accy",
                               "accz"},
              "velocity": {"vel", "velocity", "speed"},
              "position": {"pos", "position", "theta", "encoder", "displacement"}}  # fmt: skip
UNIT_OF_WORD = {"s": "s", "sec": "s", "ms": "ms", "us": "us", "ns": "ns", "g": "g", "mg": "mg", "db": "db",
                "deg": "deg", "degrees": "deg", "rad": "rad", "rads": "rad/s", "mms2": "mm/s^2", "mm/s2": "mm/s^2",
                "mm/s^2": "mm/s^2", "mm/s²": "mm/s^2", "m/s2": "m/s^2", "m/s^2": "m/s^2", "m/s²": "m/s^2",
                "ms2": "m/s^2", "rad/s": "rad/s", "hz": "hz", "mm": "mm", "mm/s": "mm/s", "m": "m",
                "°": "deg"}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """One column. role: of ROLES or ''; axis: 'x', 'y', 'z', 'xyz' or ''; quantity, unit: '' where not named."""

    name: str
    role: str
    axis: str
    quantity: str
    unit: str


def column(name: str) -> Column:
    """What a name says: accel_cmd_y, `Time [s]`, acc_x (m/s^2), psd_xyz, $\\theta$."""
    lowered = name.lower()
    bracketed = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]", lowered)
    bare = re.sub(r"[\[(].*", "", lowered)
    words = [word for word in re.split(r"[^a-z0-9#]+", bare) if word]
    unit = UNIT_OF_WORD.get(bracketed.group(1), "") if bracketed else ""
    if not unit and len(words) > 1:
        unit = UNIT_OF_WORD.get(words[-1], "")
    role = next((role for role, known in ROLES.items() if known & set(words)), "")
    axis = next((AXES[word] for word in reversed(words) if word in AXES), "")
    quantity = next((quantity for quantity, known in QUANTITIES.items() if known & set(words)), "")
    return Column(name, role, axis, quantity, unit)


def columns_of(table: TextTable) -> tuple[Column, ...]:
    """The columns of a table; without a header all are unknown."""
    return tuple(column(name) for name in table.header or [""] * table.values.shape[1])


def chosen(table: TextTable, columns: Sequence[Column], wanted: str, option: str) -> int:
    """Index of the column that a user names, by name or by number from 1. RecordingError where there is none."""
    names = [one.name.lower() for one in columns]
    if wanted.lower() in names:
        return names.index(wanted.lower())
    if wanted.isdigit() and 1 <= int(wanted) <= len(columns):
        return int(wanted) - 1
    has = f"its columns are {', '.join(table.header)}" if table.header else f"it has {len(columns)} columns, no names"
    raise table.error(f"no column {wanted!r} for {option}: {has}", remedy="name one, or give its number from 1")


def of_role(columns: Sequence[Column], role: str) -> list[int]:
    """Indices of the columns of a role."""
    return [i for i, one in enumerate(columns) if one.role == role]
