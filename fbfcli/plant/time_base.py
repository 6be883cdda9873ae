"""When samples were taken: the true rate, and what is odd about the times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.text_table import TextTable

FEWEST = 32  # samples; less is no recording
GAP = 1.75  # median periods between two samples: one is missing
JITTER = 0.25  # of a period, rms: more is told
REPEATED = 0.3  # of all times: then they are those of batches, not of samples
MS_STEP, US_STEP = 0.5, 100.0  # a clock without a unit that steps by more counts ms, us: motion needs 10 Hz
UNITS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}


@dataclass(frozen=True)
class TimeBase:
    """Times of the samples that are kept.

    fs    : [Hz]
    t     : ndarray, shape (m,)          from 0, rising [s]
    keep  : ndarray of int, shape (m,)   rows of the table
    notes : gaps, jitter, repeated times
    """

    fs: float
    t: np.ndarray
    keep: np.ndarray
    notes: tuple[str, ...]


def time_base(time: np.ndarray, unit: str | None, table: TextTable) -> TimeBase:
    """The clock of a column of times, shape (n,), in `unit` (None: recognised). Raises RecordingError."""
    _enough(len(time), table)
    step = np.diff(time)
    back = np.flatnonzero(step < 0)
    if len(back):
        raise table.error(f"time goes back from {time[back[0]]:g} to {time[back[0] + 1]:g}", int(back[0]) + 1,
                          "two recordings in one file? Split them")  # fmt: skip
    notes: list[str] = []
    if unit is None:
        typical = float(np.median(step[step > 0])) if (step > 0).any() else 0.0
        unit = "us" if typical >= US_STEP else "ms" if typical >= MS_STEP else "s"
        if unit != "s":
            notes.append(f"times are taken to be in {unit}")
    if (step == 0).mean() > REPEATED:
        return _of_batches(time * UNITS[unit], table, notes)
    keep = np.concatenate([[0], np.flatnonzero(step > 0) + 1])
    if len(keep) < len(time):
        first = int(table.line[np.flatnonzero(step == 0)[0] + 1])
        notes.append(f"{len(time) - len(keep)} rows repeat the time of the row before and are left out, "
                     f"the first in line {first}")  # fmt: skip
    _enough(len(keep), table)
    t = (time[keep] - time[keep[0]]) * UNITS[unit]
    fs, more = _rate(t, table.line[keep])
    return TimeBase(fs, t, keep, tuple(notes + more))


def counted(n: int, fs: float, table: TextTable) -> TimeBase:
    """The clock of a file without times whose rate is known."""
    _enough(n, table)
    return TimeBase(fs, np.arange(n) / fs, np.arange(n), ())


def _rate(t: np.ndarray, line: np.ndarray) -> tuple[float, list[str]]:
    """fs by regression of the times on the count of periods, missing samples counted; gaps and jitter in words."""
    step = np.diff(t)
    period = float(np.median(step))
    around = np.convolve(step, np.ones(3), "same")  # under jitter a long step stands beside short ones; after a gap not
    wide = np.flatnonzero((step > GAP * period) & (around > (2.0 + 0.8 * GAP) * period))
    count = np.ones(len(step))
    count[wide] = np.round(step[wide] / period)
    k = np.concatenate([[0.0], np.cumsum(count)])
    slope, start = np.polyfit(k, t, 1)
    notes = []
    if len(wide):
        longest = wide[np.argmax(step[wide])]
        notes.append(f"{len(wide)} gap{'s' if len(wide) > 1 else ''}, {count[wide].sum() - len(wide):.0f} samples "
                     f"missing, the longest {1e3 * step[longest]:.1f} ms before line {line[longest + 1]}")  # fmt: skip
    jitter = float(np.std(t - start - slope * k)) / slope
    if jitter > JITTER:
        notes.append(f"times jitter by {1e3 * jitter * slope:.2f} ms rms")
    return 1.0 / float(slope), notes


def _of_batches(time: np.ndarray, table: TextTable, notes: list[str]) -> TimeBase:
    """A clock that was read once per batch of samples: only its ends count."""
    first = np.flatnonzero(np.diff(time) > 0) + 1
    if len(first) < 2:
        raise table.error("the time stands still", 1, "give --rate")
    fs = float((first[-1] - first[0]) / (time[first[-1]] - time[first[0]]))
    words = f"times are those of batches of {(first[-1] - first[0]) / (len(first) - 1):.0f} samples, spread evenly"
    return TimeBase(fs, np.arange(len(time)) / fs, np.arange(len(time)), (*notes, words))


def _enough(n: int, table: TextTable) -> None:
    if n < FEWEST:
        raise table.error(f"{n} samples are no recording", remedy=f"at least {FEWEST} are needed; the capture failed")
