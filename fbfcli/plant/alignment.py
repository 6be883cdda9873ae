"""Command and measurement on one clock."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.clock_search import Alignment, Coarse, Track, coarse, refined
from fbfcli.plant.excitation import Sweep, acceleration, until
from fbfcli.plant.klipper_test import klipper_test, klipper_test_2020
from fbfcli.plant.recording import Recording

SPAN = {"ulendo": 0.03, "adxl": 0.06, "duet": 0.06}  # how far the rate of a kind may be off, as a part of it
SPAN_TIMED = 0.02  # of one whose samples carry the host's times
UNEVEN = 1e-3  # of a period, rms, by which times may jitter before they are evened out
SHORTEST = 4.0  # s: less is no sweep
LEAST_CORRELATION = 0.4  # of a command that is found; of another test, or of noise, it stays below
LOOSE_GAIN = (0.85, 1.15)  # where the machine is rigid: outside, the command's amplitude is another
BEFORE, AFTER = 0.5, 1.0  # s kept around the sweep
STILL = 0.25  # of the typical acceleration of a sweep: below it, it is over
STILL_WINDOW = 0.25  # s


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
    sweep       : what was commanded; None for a recorded pair
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
    sweep: Sweep | None = None
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> np.ndarray:
        """What the moved axis' own column shows, shape (n,)."""
        return np.asarray(self.response[:, self.columns.index(self.axis)])


def paired(recording: Recording, sweep: Sweep | None = None, axis: str | None = None) -> Pair:
    """Command and response of a recording; the command is rebuilt from the `sweep` where it is not recorded.

    Klipper's raw files do not tell the test: without a `sweep`, TEST_RESONANCES with Klipper's defaults is looked for.
    Raises RecordingError where nothing is known of the command, or it cannot be found in the measurement.
    """
    moved = axis or recording.axis
    if moved is None:
        raise RecordingError("the file does not tell which axis was moved", file=recording.name, remedy="give --axis")
    if recording.axis not in (None, moved):
        raise RecordingError(f"the file says that {recording.axis} was moved", file=recording.name,
                             remedy=f"give --axis {recording.axis}")  # fmt: skip
    if moved not in recording.columns:
        raise RecordingError(f"no measurement of axis {moved}", file=recording.name, remedy="choose another --axis")
    response = _even(recording, recording.measured)
    response = response - response.mean(axis=0)
    if recording.command is not None:
        command = _even(recording, recording.command[:, None])[:, 0]
        return Pair(recording.fs, command, response, recording.columns, moved, notes=recording.notes)
    if sweep is None and recording.sweep is None and recording.kind != "klipper raw":
        raise RecordingError("nothing is known of the command", file=recording.name,
                             remedy="give the test that was run with --sweep")  # fmt: skip
    known = sweep or recording.sweep
    tests = (known,) if known else klipper_defaults()
    if len(response) < SHORTEST * recording.fs:
        raise RecordingError(f"{len(response) / recording.fs:.1f} s are too short to hold a sweep", file=recording.name,
                             remedy="record the whole test")  # fmt: skip
    track = Track(recording.fs, response[:, recording.columns.index(moved)])
    start, test = _likeliest(track, tests, SPAN.get(recording.kind, SPAN_TIMED))
    if start.correlation < LEAST_CORRELATION:
        names = " or ".join(sorted({one.name for one in tests}))
        raise RecordingError(f"{names} is not found in it: correlation {start.correlation:.2f}",
                             file=recording.name, remedy="give the test that was run with --sweep")  # fmt: skip
    return _rebuilt(recording, response, refined(track, test, start), test, moved)


def klipper_defaults() -> tuple[Sweep, ...]:
    """TEST_RESONANCES as it comes and came, to the highest frequency that it takes."""
    tests = klipper_test(f1=300.0), klipper_test(f1=300.0, sweeping_period=0.0), klipper_test_2020(f1=300.0)
    return tuple(replace(test, open_end=True, scalable=True) for test in tests)


def _even(recording: Recording, values: np.ndarray) -> np.ndarray:
    """Values, shape (n, k), at even times: straight lines across gaps, and where the times jitter."""
    k = recording.t * recording.fs
    even = np.arange(int(np.round(k[-1])) + 1)
    if len(even) == len(k) and np.std(k - even) < UNEVEN:
        return values
    return np.column_stack([np.interp(even, k, column) for column in values.T])


def _likeliest(track: Track, tests: tuple[Sweep, ...], span: float) -> tuple[Coarse, Sweep]:
    """The test that correlates best, and where; one with an open end is cut before the machine stopped."""
    long = track.t[-1] * (1 + span)
    tests = tuple(until(test, long) if test.open_end else test for test in tests)
    start, test = max(((coarse(track, test, span), test) for test in tests), key=lambda one: one[0].correlation)
    stopped = start.clock * (_stopped(track) - STILL_WINDOW) + start.delay
    return start, until(test, stopped) if test.open_end and stopped > 0 else test


def _stopped(track: Track) -> float:
    """When the shaking is over [s]."""
    size = max(1, int(STILL_WINDOW * track.fs))
    rms = np.sqrt(np.add.reduceat(track.y**2, np.arange(0, len(track.y), size)) / size)
    moving = np.flatnonzero(rms >= STILL * np.percentile(rms, 75))
    return float((moving[-1] + 1) * size / track.fs)


def _rebuilt(recording: Recording, response: np.ndarray, found: Alignment, test: Sweep, moved: str) -> Pair:
    """The pair, around the sweep, with what is to be told of the alignment."""
    n, step = len(response), found.clock / recording.fs
    t = found.clock * np.arange(n) / recording.fs + found.delay
    keep = slice(*np.searchsorted(t, [-BEFORE, test.duration + (0.0 if test.open_end else AFTER)]))
    u = acceleration(test, t[keep], step)  # a mean over each period, as a sensor's own filter makes it
    notes = [*recording.notes, f"{test.name} found: correlation {found.correlation:.3f} below 15 Hz, the first sample "
             f"{found.delay:+.4f} s after its start, true rate {1 / step:.2f} Hz"]  # fmt: skip
    y = response[keep]
    if found.correlation < 0:
        y, notes = -y, [*notes, f"{moved} is measured upside down, and turned"]
    gain = abs(found.gain)
    if not LOOSE_GAIN[0] < gain < LOOSE_GAIN[1]:
        if test.scalable:
            u = u * gain
            notes.append(f"the command is taken to be {gain:.2f} times the default: the machine follows it so")
        else:
            notes.append(f"the gain is {gain:.2f} where the machine is rigid: are unit and amplitude right?")
    first = t[keep][0]
    rows = [(int((a - first) / step), int(np.ceil((b - first) / step)), size) for a, b, size in test.segments]
    return Pair(1 / step, u, y - y.mean(axis=0), recording.columns, moved, found.delay, found.clock, found.correlation,
                tuple(rows), test, tuple(notes))  # fmt: skip


def command_at(sweep: Sweep, t: np.ndarray, step: float) -> np.ndarray:
    """What an ideal sensor with a sampling period of `step` [s] sees of a command at even times.

    The mean over each period keeps edges in place and folds nothing over, but lowers high frequencies by
    sin(x) / x, x = pi f step. One minus a 24th of the second difference undoes that to x^4.
    """
    mean = acceleration(sweep, np.concatenate([[t[0] - step], t, [t[-1] + step]]), step)
    return np.asarray(mean[1:-1] - np.diff(mean, 2) / 24)
