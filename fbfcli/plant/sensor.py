"""What an accelerometer adds to the motion: gravity, tilt, and a range that ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fbfcli.units import GRAVITY

TILT = 10.0  # degrees from the nearest axis: more is told
CLIPPED = 3  # samples in a row on the largest value that was seen
FAR = 20  # of its own quantisation steps, that this value must be off the median: else it is noise at rest
UNITS = {"mm/s^2": 1.0, "mm/s2": 1.0, "mm/s²": 1.0, "m/s^2": 1e3, "m/s2": 1e3, "m/s²": 1e3,
         "g": GRAVITY, "mg": 1e-3 * GRAVITY}  # fmt: skip
NEAR_ONE_G = (0.7, 1.4)  # of g: what the median of three axes may amount to, tilt and offsets included


def unit_by_gravity(measured: np.ndarray) -> str | None:
    """The unit in which three axes, shape (n, 3), show one g at rest; None where they show none."""
    size = float(np.linalg.norm(np.median(measured, axis=0)))
    for unit in ("g", "m/s^2", "mg", "mm/s^2"):
        if NEAR_ONE_G[0] < size * UNITS[unit] / GRAVITY < NEAR_ONE_G[1]:
            return unit
    return None


def oddities(measured: np.ndarray, columns: Sequence[str], line: np.ndarray) -> tuple[str, ...]:
    """Clipping and tilt of accelerations, shape (n, k) [mm/s^2], in words; `line` names rows in the file."""
    found = []
    for i, column in enumerate(columns):
        for end, word in ((measured[:, i].max(), "top"), (measured[:, i].min(), "bottom")):
            where = clipped(measured[:, i], float(end))
            if len(where):
                found.append(f"{column} is clipped at the {word} ({end / GRAVITY:+.1f} g) {len(where)} times, first in "
                             f"line {line[where[0]]}")  # fmt: skip
    rest = np.median(measured, axis=0)
    size = float(np.linalg.norm(rest))
    if len(columns) == 3 and NEAR_ONE_G[0] < size / GRAVITY < NEAR_ONE_G[1]:
        tilt = float(np.degrees(np.arccos(np.abs(rest).max() / size)))
        if tilt > TILT:
            found.append(f"the sensor is tilted by {tilt:.0f} degrees against gravity, or has an offset")
    return tuple(found)


def clipped(column: np.ndarray, end: float) -> np.ndarray:
    """First samples of the stretches, CLIPPED long or longer, that stay on the extreme value `end`."""
    levels = np.unique(column)
    if len(levels) < 2 or abs(end - np.median(column)) < FAR * np.diff(levels).min():
        return np.zeros(0, dtype=np.int64)
    on = np.concatenate([[0], (column == end).astype(np.int8), [0]])
    begin, stop = np.flatnonzero(np.diff(on) == 1), np.flatnonzero(np.diff(on) == -1)
    return begin[stop - begin >= CLIPPED]
