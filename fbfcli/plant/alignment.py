"""Command and measurement on one clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.excitation import Sweep
from fbfcli.plant.recording import Recording


@dataclass(frozen=True)
class Pair:
    """What a frequency response is computed from: uniform samples on the command's clock.

    fs          : [Hz]
    command     : ndarray, shape (n,)     [mm/s^2], or mm/s or mm where the recording's quantity is another
    response    : ndarray, shape (n, k)   of `columns`, mean removed
    columns     : 'x', 'y', 'z'
    axis        : the moved axis, one of `columns`
    delay       : of the measurement's first sample after the command's start, found [s]; 0 for a recorded pair
    clock       : seconds of the command's clock in one of the recording's
    correlation : of command and measurement where the machine is rigid; 1 for a recorded pair
    segments    : (begin, end, amplitude) in samples of stretches of one amplitude; empty: one
    notes       : of the recording, and of the alignment
    """

    fs: float
    command: np.ndarray
    response: np.ndarray
    columns: tuple[str, ...]
    axis: str
    delay: float = 0.0
    clock: float = 1.0
    correlation: float = 1.0
    segments: tuple[tuple[int, int, float], ...] = ()
    notes: tuple[str, ...] = ()


def paired(recording: Recording, sweep: Sweep | None = None, axis: str | None = None) -> Pair:
    """Command and response of a recording; the command is rebuilt from the `sweep` where it is not recorded.

    Raises RecordingError where nothing is known of the command, or it cannot be found in the measurement.
    """
    moved = axis or recording.axis
    if moved is None:
        raise RecordingError("the file does not tell which axis was moved", file=recording.name, remedy="give --axis")
    if moved not in recording.columns:
        raise RecordingError(f"no measurement of axis {moved}", file=recording.name, remedy="choose another --axis")
    if recording.command is None:
        raise RecordingError("nothing is known of the command", file=recording.name, remedy="give --sweep")
    response = recording.measured - recording.measured.mean(axis=0)
    return Pair(recording.fs, recording.command, response, recording.columns, moved, notes=recording.notes)
