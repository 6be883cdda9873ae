"""What Klipper would choose: its shapers scored on a power spectrum, as its own calibration does.

A, T : weights and times of a shaper's impulses      psd : power of the accelerations measured, by frequency
Rules and constants of klippy/extras/shaper_calibrate.py and shaper_defs.py: they have "no special meaning", as it says
there, and work well on users' data. They are given here as facts, for comparison, as they are since 2024: before, the
EI family had other impulses (control.shapers) and no vibration was tolerated, so older files tell other frequencies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.signal import welch

LOWEST_HZ = {"zv": 21.0, "mzv": 23.0, "ei": 29.0, "2hump_ei": 39.0, "3hump_ei": 48.0}
HIGHEST_HZ, STEP_HZ = 200.0, 0.2
BAND_HZ = 5.0, 200.0
DAMPING = 0.1  # that shapers are designed for
DAMPINGS = 0.075, 0.1, 0.15  # that they must cope with
TOLERATED = 0.0005  # vibration left that makes no difference, since 2024
REDUCTION = 20.0  # vibrations below 1 / 20 of the strongest are not looked at
SMOOTHING_MM = 0.12  # that the suggested acceleration leads to
ACCELERATION, CORNER = 5000.0, 5.0  # mm/s^2 and mm/s that smoothing is told for
WINDOW_S = 0.5

Impulses = Callable[[str, float, float], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Scored:
    """One shaper: its frequency [Hz], vibrations left (0 to 1), smoothing [mm], score."""

    name: str
    frequency: float
    vibrations: float
    smoothing: float
    score: float


def klipper_spectrum(measured: np.ndarray, fs: float) -> tuple[np.ndarray, np.ndarray]:
    """f, psd [Hz], (mm/s^2)^2/Hz: the three axes' sum, windows of half a second, Kaiser 6, as Klipper computes it."""
    size = 1 << int(fs * WINDOW_S - 1).bit_length()
    f, psd = welch(measured, fs, ("kaiser", 6.0), min(size, len(measured)), axis=0)
    return f, psd.sum(axis=1)


def normalised(f: np.ndarray, psd: np.ndarray) -> np.ndarray:
    """The spectrum over frequency, as a test whose acceleration rises with it excites it; without slow noise."""
    low = f < 2 * BAND_HZ[0]
    slow = np.exp(1 - (2 * BAND_HZ[0] / (f + 0.1)) ** 2)
    return np.asarray(psd / (f + 0.1) * np.where(low, slow, 1.0))


def best_shaper(f: np.ndarray, psd: np.ndarray, impulses: Impulses) -> tuple[Scored, tuple[Scored, ...]]:
    """Klipper's choice, and its choice of each kind, for a normalised spectrum."""
    within = f <= BAND_HZ[1]
    best: Scored | None = None
    kinds = []
    for name in LOWEST_HZ:
        tried = _scored(name, f[within], psd[within], impulses)
        kind = _selected(tried)
        if best is None or _better(kind, best):
            best = kind
        for one in tried:
            if one.vibrations < best.vibrations and one.smoothing < best.smoothing:
                best = kind = one
        kinds.append(kind)
    assert best is not None
    if best.name == "zv":
        zv = best
        best = next((k for k in kinds if k.name != "zv" and 1.1 * k.vibrations < zv.vibrations), zv)
    return best, tuple(kinds)


def fitted(name: str, f: np.ndarray, psd: np.ndarray, impulses: Impulses) -> Scored:
    """The frequency that Klipper gives one kind, for a normalised spectrum."""
    within = f <= BAND_HZ[1]
    return _selected(_scored(name, f[within], psd[within], impulses))


def _scored(name: str, f: np.ndarray, psd: np.ndarray, impulses: Impulses) -> list[Scored]:
    """Every frequency of one kind, rising."""
    tried = []
    floor = psd.max() / REDUCTION
    total = max(float(np.maximum(psd - floor, 0).sum()), 1e-30)
    for frequency in np.arange(LOWEST_HZ[name], HIGHEST_HZ, STEP_HZ):
        A, T = impulses(name, float(frequency), DAMPING)
        left = max(float(np.maximum(residual(A, T, z, f) * psd - floor, 0).sum()) for z in DAMPINGS) / total
        smooth = smoothing(A, T, ACCELERATION)
        score = smooth * (left**1.5 + 0.2 * left + 0.01)
        tried.append(Scored(name, float(frequency), left, smooth, score))
    return tried


def _selected(tried: Sequence[Scored]) -> Scored:
    """The best score among those that leave hardly more vibration than the best does."""
    least = min(reversed(tried), key=lambda one: one.vibrations)
    good = [one for one in tried if one.vibrations < 1.1 * least.vibrations + TOLERATED]
    return min([least, *good], key=lambda one: one.score)


def _better(new: Scored, old: Scored) -> bool:
    return 1.2 * new.score < old.score or (1.05 * new.score < old.score and 1.1 * new.smoothing < old.smoothing)


def residual(A: np.ndarray, T: np.ndarray, damping: float, f: np.ndarray) -> np.ndarray:
    """Vibration that the impulses leave of each frequency, (m,): 1 without a shaper."""
    w = 2 * np.pi * f
    W = A * np.exp(-damping * np.outer(w, T[-1] - T))
    turned = np.sqrt(1 - damping**2) * np.outer(w, T)
    return np.asarray(np.hypot((W * np.sin(turned)).sum(axis=1), (W * np.cos(turned)).sum(axis=1)) / A.sum())


def smoothing(A: np.ndarray, T: np.ndarray, acceleration: float) -> float:
    """How far corners of 90 and 180 degrees are cut [mm], at Klipper's square corner velocity."""
    t = T - A @ T
    late = t >= 0
    right_angle = np.sqrt(2) * np.sum(A[late] * (CORNER + 0.5 * acceleration * t[late]) * t[late])
    turning_back = 0.5 * acceleration * np.sum(A * t**2)
    return float(max(right_angle, turning_back))


def most_acceleration(A: np.ndarray, T: np.ndarray) -> float:
    """The acceleration [mm/s^2] at which smoothing reaches what Klipper suggests as the most; 0 if it always does."""
    if smoothing(A, T, 0.0) >= SMOOTHING_MM:
        return 0.0
    return float(brentq(lambda a: smoothing(A, T, a) - SMOOTHING_MM, 0.0, 1e9))
