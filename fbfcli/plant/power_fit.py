"""Modes from a magnitude alone: a power spectrum, or a response without phase. Minimum phase is assumed, not found.

ln P = ln G + k ln f + 2 ln |H(f)|     G: a scale that nobody knows; k: how the excitation's power rises with frequency
A square wave of acceleration that grows with frequency, swept at a constant rate (Klipper's test), has k = 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import find_peaks

from fbfcli.errors import ModelError
from fbfcli.plant.intervals import Interval, ModeEstimate, of_logarithm
from fbfcli.plant.rational import Rational, Resonance, response

MOST_MODES = 3
DAMPING = (2e-3, 0.5)
FIRST_GUESS = 0.05  # of damping
LEAST_LINES = 20
FLOOR = 1e-3  # of the largest power: below it, noise
PROMINENCE = 0.5  # in ln P, of a peak worth starting from


@dataclass(frozen=True)
class PowerFit:
    """Modes of a magnitude: the model, modes with intervals, rms of what is left in ln P, and its criterion."""

    model: Rational
    modes: tuple[ModeEstimate, ...]
    residual: float
    criterion: float


def power_fit(frequency: np.ndarray, power: np.ndarray, rise: float) -> tuple[PowerFit, ...]:
    """Sums of one to three modes with positive gains, chosen one first.

    frequency, power : ndarray, shape (m,)   [Hz], any scale
    rise             : k, by which the excitation's power rises with frequency

    Raises ModelError where there are too few lines, or no peak.
    """
    kept = (frequency > 0) & (power > FLOOR * power.max(initial=0.0))
    f, logP = frequency[kept], np.log(power[kept]) - rise * np.log(frequency[kept])
    if len(f) < LEAST_LINES:
        raise ModelError(f"{len(f)} lines of the spectrum hold power; {LEAST_LINES} are needed")
    smooth = np.convolve(np.pad(logP, 2, "edge"), np.full(5, 0.2), "valid")
    peaks, _ = find_peaks(smooth, prominence=PROMINENCE)
    if not len(peaks):
        raise ModelError("the spectrum has no peak")
    starts = f[peaks[np.argsort(smooth[peaks])[::-1]]]
    fits = [_fitted(f, logP, starts[:n]) for n in range(1, min(MOST_MODES, len(starts)) + 1)]
    return tuple(sorted(fits, key=lambda fit: fit.criterion))


def _fitted(f: np.ndarray, logP: np.ndarray, starts: np.ndarray) -> PowerFit:
    n = len(starts)
    start = np.concatenate(([np.median(logP)], np.log(starts), np.full(n, np.log(FIRST_GUESS)), np.zeros(n - 1)))
    low = np.concatenate(([-np.inf], np.full(n, np.log(f[0])), np.full(n, np.log(DAMPING[0])), np.full(n - 1, -8.0)))
    high = np.concatenate(([np.inf], np.full(n, np.log(f[-1])), np.full(n, np.log(DAMPING[1])), np.full(n - 1, 4.0)))

    weight = np.exp(0.25 * (logP - logP.max()))  # the peaks are what shakes a print, skirts hold noise

    def residual(x: np.ndarray) -> np.ndarray:
        return weight * (x[0] + 2 * np.log(np.abs(response(_model(x, n), f))) - logP)

    found = least_squares(residual, np.clip(start, low + 1e-6, high - 1e-6), bounds=(low, high), loss="soft_l1")
    left = residual(found.x)
    m, k = len(f), len(found.x)
    cov = np.linalg.pinv(found.jac.T @ found.jac) * float(left @ left) / max(m - k, 1)
    spread = np.sqrt(np.diag(cov))
    model = _model(found.x, n)
    modes = [
        ModeEstimate(of_logarithm(r.frequency, spread[1 + i]), of_logarithm(r.damping, spread[1 + n + i]),
                     Interval(r.gain, r.gain, r.gain))
        for i, r in enumerate(model.resonances)
    ]  # fmt: skip
    order = np.argsort([-r.gain / r.damping for r in model.resonances])
    return PowerFit(model, tuple(modes[i] for i in order), float(np.std(left)),
                    float(m * np.log(left @ left / m) + 3 * k * np.log(m)))  # fmt: skip


def _model(x: np.ndarray, n: int) -> Rational:
    """Gains are shares exp(x) / sum: positive, sum 1."""
    shares = np.exp(np.concatenate(([0.0], x[1 + 2 * n :])))
    rows = zip(np.exp(x[1 : 1 + n]), np.exp(x[1 + n : 1 + 2 * n]), shares / shares.sum(), strict=True)
    return Rational(tuple(Resonance(*map(float, row)) for row in rows))
