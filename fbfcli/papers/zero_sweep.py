"""The plant with a movable zero that Ramani 2020 tries every method on (ch. 2, 3): G = (q - a) / (q - p), p = 0.5.

M + 1 samples of white noise are the desired trajectory y_d; n + 1 basis functions; a zero, p pole, n_1 terms of the
truncated series.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from fbfcli.control.bases import block_pulses, dct
from fbfcli.control.bspline import bsplines, normalised_time

M, N, N_1 = 1000, 990, 5
POLE = 0.5
DEGREE = 5  # of the splines, Ramani 2020
BASES = {  # the plant's zero leaves them as they are
    "DCT": lambda: dct(M, N),
    "B-splines": lambda: bsplines(normalised_time(M), N, DEGREE),
    "block pulses": lambda: block_pulses(M, N),
}


def zeros(step: float) -> np.ndarray:
    """a = -5..5 in steps, free of rounding: -1, 0 and 1 are exact where a step meets them."""
    count = round(10 / step)
    return (10 * np.arange(count + 1) - 5 * count) / count


def filtered(a: float, Phi: np.ndarray) -> np.ndarray:
    """G Phi, Ramani 2020 Eq. 2.27."""
    return lfilter([1.0, -a], [1.0, -POLE], Phi, axis=0)


def noise(seeds: int) -> np.ndarray:
    """Desired trajectories of unit variance, one per column, shape (M + 1, seeds)."""
    return np.stack([np.random.default_rng(seed).standard_normal(M + 1) for seed in range(seeds)], axis=1)


def relative_rms(x: np.ndarray, y_d: np.ndarray) -> np.ndarray:
    """x_RMS / y_d,RMS of each column."""
    return np.linalg.norm(x, axis=0) / np.linalg.norm(y_d, axis=0)


def zpetc_metric(a: float) -> float:
    """J_e of ZPETC, Eq. 2.28."""
    return float(np.sqrt(6 - 2 / (M + 1)) * abs(a) / (1 - a) ** 2)


def series_metric(a: float) -> float:
    """J_e of TS, Eq. 2.29."""
    return float(np.sqrt(1 - N_1 / (M + 1)) * (abs(a) ** -N_1 if abs(a) > 1 else abs(a) ** N_1))
