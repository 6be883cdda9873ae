"""Recordings are read by their content, whatever they are called."""

from __future__ import annotations

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.recording import Read, ReadOptions, Recording


def read_recordings(data: bytes, name: str, options: ReadOptions | None = None) -> tuple[Read, ...]:
    """Everything that one file holds. Raises RecordingError: file, line, what is wrong and the remedy."""
    text = data.decode("utf-8-sig", errors="replace")
    head = text.split("\n", 1)[0].strip().split(",")
    if "accel_cmd_y" not in head:
        raise RecordingError("is no recording that can be read", file=name)
    table = np.loadtxt(text.splitlines()[1:], delimiter=",", ndmin=2)
    t = table[:, 0]
    fs = (len(t) - 1) / (t[-1] - t[0])
    return (Recording("pair", name, fs, t - t[0], table[:, 2:], ("x", "y", "z"), table[:, 1], axis="y"),)
