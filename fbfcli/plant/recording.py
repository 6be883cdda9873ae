"""What people record: a capture, a power spectrum, a frequency response. Read by `recordings`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.excitation import Sweep


@dataclass(frozen=True)
class Recording:
    """One capture.

    kind     : 'pair', 'klipper raw', 'duet', 'ulendo' or 'adxl'; only a 'pair' holds its command
    name     : the file, for messages
    fs       : true sampling rate, estimated from the times where there are any [Hz]
    t        : ndarray, shape (n,)     from 0, rising, as given [s]
    measured : ndarray, shape (n, k)   accelerations of `columns`, gravity included [mm/s^2]
    columns  : names of these, 'x', 'y', 'z'
    command  : ndarray, shape (n,)     commanded, of `axis`; None where it is not recorded [mm/s^2]
    axis     : 'x', 'y' or None: the axis that was moved, where the file tells
    sweep    : what the test commands, where the file tells
    quantity : 'acceleration'; command and measurement of a pair may be of 'velocity' or 'position' [mm/s, mm] instead:
               their ratio is the same response
    notes    : what was repaired or looks odd (gaps, clipping, tilt, overflows), with places
    """

    kind: str
    name: str
    fs: float
    t: np.ndarray
    measured: np.ndarray
    columns: tuple[str, ...]
    command: np.ndarray | None = None
    axis: str | None = None
    sweep: Sweep | None = None
    quantity: str = "acceleration"
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class PowerSpectrum:
    """A power spectral density, of no known scale and without phase.

    name      : the file, for messages
    frequency : ndarray, shape (n,)     rising [Hz]
    power     : ndarray, shape (n, k)   of `columns`, of accelerations squared, >= 0
    columns   : 'x', 'y', 'z', 'xyz'
    shapers   : (name, frequency [Hz]) of shapers that the file scores
    notes     : what was repaired or looks odd
    """

    name: str
    frequency: np.ndarray
    power: np.ndarray
    columns: tuple[str, ...]
    shapers: tuple[tuple[str, float], ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ResponseTable:
    """A frequency response that somebody measured already.

    name      : the file, for messages
    frequency : ndarray, shape (n,)             rising [Hz]
    response  : ndarray of complex, shape (n,)  position by position, or acceleration by acceleration [1]
    coherence : ndarray, shape (n,)             or None
    has_phase : False where the file gives the magnitude only; `response` is then real
    axis      : 'x', 'y' or None
    notes     : what was repaired or looks odd
    """

    name: str
    frequency: np.ndarray
    response: np.ndarray
    coherence: np.ndarray | None = None
    has_phase: bool = True
    axis: str | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ReadOptions:
    """What a user says of a file that it does not say itself; None: found in the file.

    time, command, measured : names or numbers (from 1) of columns of a table
    unit                    : of accelerations: 'mm/s^2', 'm/s^2', 'g', 'mg'
    rate                    : samples per second, of a file without times [Hz]
    """

    time: str | None = None
    command: str | None = None
    measured: str | None = None
    unit: str | None = None
    rate: float | None = None


Read = Recording | PowerSpectrum | ResponseTable
