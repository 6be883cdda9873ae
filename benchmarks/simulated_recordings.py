"""Recordings of machines whose truth is known: a test's command through a plant, seen by an ADXL345.

The sensor: 3.9 mg per step, a range of +-16 g, its own clock, jitter, gravity, tilt, noise, and a start that nobody
knows. Used by tests and by `identify_truth.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import freqz

from fbfcli.plant.alignment import command_at
from fbfcli.plant.excitation import Sweep
from fbfcli.plant.recording import Recording
from fbfcli.printer import Mode
from fbfcli.units import GRAVITY

LSB = 3.9e-3 * GRAVITY
RANGE = 16.0 * GRAVITY
OVERSAMPLED = 4  # times the sensor's rate, at which the motion is computed
RINGS = 3.0  # s added, in which every machine comes to rest
REST = (0.3, 1.5)  # s recorded before the test, at random between these
AFTER = 0.7  # s recorded after it


@dataclass(frozen=True)
class Sensor:
    """What one ADXL345 does to a motion.

    fs           : nominal rate [Hz]
    clock_error  : part by which its times are long against the machine's
    jitter       : rms, of a period, of the moments at which it samples
    tilt         : against the machine's axes [rad]
    noise        : rms, of the rms of the acceleration
    stamped      : rounding of the times written [s]
    """

    fs: float = 3200.0
    clock_error: float = 0.0
    jitter: float = 0.0
    tilt: float = 0.0
    noise: float = 0.0
    stamped: float = 1e-6


def drawn_sensor(rng: np.random.Generator) -> Sensor:
    """One of those that the benchmark promises to cope with."""
    return Sensor(clock_error=rng.uniform(-5e-3, 5e-3), jitter=rng.uniform(0.0, 0.05),
                  tilt=np.radians(rng.uniform(0.0, 5.0)), noise=0.05)  # fmt: skip


Response = Callable[[np.ndarray], np.ndarray]  # complex response at frequencies [Hz]


def modal(modes: Sequence[Mode]) -> Response:
    """The response of a sum of modes."""

    def response(f: np.ndarray) -> np.ndarray:
        parts = [mode.gain / (1 - (f / mode.frequency) ** 2 + 2j * mode.damping * f / mode.frequency) for mode in modes]
        return np.asarray(sum(parts))

    return response


def discrete(b: Sequence[float], a: Sequence[float], dt: float) -> Response:
    """The response of a discrete transfer function; past its Nyquist frequency it falls with f^2."""
    top = 0.5 / dt

    def response(f: np.ndarray) -> np.ndarray:
        within = np.minimum(f, 0.999 * top)
        return np.asarray(freqz(b, a, within, fs=2 * top)[1] * np.minimum(1.0, top / np.maximum(f, 1e-9)) ** 2)

    return response


def recorded(sweep: Sweep, response: Response, sensor: Sensor, axis: str, rng: np.random.Generator) -> Recording:
    """A recording as Klipper writes it."""
    fs = OVERSAMPLED * sensor.fs
    before = rng.uniform(*REST)
    t = np.arange(int((before + sweep.duration + AFTER) * fs)) / fs
    size = next_fast_len(int(len(t) + RINGS * fs), real=True)
    command = command_at(sweep, t - before, 1 / fs)
    a = irfft(rfft(command, size) * response(rfftfreq(size, 1 / fs)), size)[: len(t)]
    n = int((t[-1] - 2 / sensor.fs) * sensor.fs) - 2
    k = np.arange(n) + sensor.jitter * rng.standard_normal(n)
    moved = np.interp((k + 1) / sensor.fs, t, _band_limited(a))
    noise = sensor.noise * np.sqrt(np.mean(moved**2)) * rng.standard_normal((n, 3))
    index, other = "xyz".index(axis), "xyz".index("y" if axis == "x" else "x")
    seen = np.zeros((n, 3))
    seen[:, index] = np.cos(sensor.tilt) * moved + np.sin(sensor.tilt) * GRAVITY
    seen[:, 2] = np.cos(sensor.tilt) * GRAVITY - np.sin(sensor.tilt) * moved
    seen[:, other] = 0.02 * moved
    values = np.clip(np.round((seen + noise) / LSB) * LSB, -RANGE, RANGE)
    stamps = np.arange(n) / sensor.fs * (1 + sensor.clock_error)
    stamps = np.round(stamps / sensor.stamped) * sensor.stamped
    return Recording("klipper raw", "simulated.csv", n / (stamps[-1] - stamps[0]) * (n - 1) / n, stamps, values,
                     ("x", "y", "z"))  # fmt: skip


def as_klipper_csv(recording: Recording) -> bytes:
    """The text that Klipper would have written."""
    rows = np.column_stack([recording.t + 531.946083, recording.measured])
    lines = [f"{t:.6f},{x:.6f},{y:.6f},{z:.6f}" for t, x, y, z in rows.tolist()]
    return "\n".join(["#time,accel_x,accel_y,accel_z", *lines, ""]).encode()


def _band_limited(a: np.ndarray) -> np.ndarray:
    """The mean over the sensor's period, as its filter leaves it."""
    return np.convolve(a, np.full(OVERSAMPLED, 1 / OVERSAMPLED), "same")
