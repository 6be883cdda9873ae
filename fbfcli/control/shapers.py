"""Input shapers: the command is the desired motion, repeated by a few impulses and centred in time.

A, T : weights (sum 1) and times [s] of the impulses      zeta damping ratio, f undamped frequency [Hz]
K    : exp(-zeta pi / sqrt(1 - zeta^2)), what half a damped period leaves of a vibration
Definitions as in Klipper's klippy/extras/shaper_defs.py (its kin_shaper.c of 2020 placed the EI family's impulses at
half periods instead); the mean delay sum(A T) is taken out as in klippy/chelper/kin_shaper.c.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, pi, sqrt

import numpy as np
from numpy.polynomial.polynomial import polyval

from fbfcli.control.compensator import AT_REST
from fbfcli.control.fir_compensator import FirCompensator
from fbfcli.errors import ModelError

V_TOL = 0.05  # vibration an EI shaper leaves at its design frequency
MAX_DAMPING = {"zv": 0.99, "mzv": 0.99, "zvd": 0.99, "ei": 0.4, "2hump_ei": 0.3, "3hump_ei": 0.2}

# Fitted by powers of zeta: impulse times in undamped periods, and weights
TWO_HUMP = (
    ((0, 0, 0, 0), (0.49890, 0.16270, -0.54262, 6.16180), (0.99748, 0.18382, -1.58270, 8.17120),
     (1.49920, -0.09297, -0.28338, 1.85710)),
    ((0.16054, 0.76699, 2.26560, -1.22750), (0.33911, 0.45081, -2.58080, 1.73650),
     (0.34089, -0.61533, -0.68765, 0.42261), (0.15997, -0.60246, 1.00280, -0.93145)),
)  # fmt: skip
THREE_HUMP = (
    ((0, 0, 0, 0), (0.49974, 0.23834, 0.44559, 12.4720), (0.99849, 0.29808, -2.36460, 23.3990),
     (1.49870, 0.10306, -2.01390, 17.0320), (1.99960, -0.28231, 0.61536, 5.40450)),
    ((0.11275, 0.76632, 3.29160, -1.44380), (0.23698, 0.61164, -2.57850, 4.85220),
     (0.30008, -0.19062, -2.14560, 0.13744), (0.23775, -0.73297, 0.46885, -2.08650),
     (0.11244, -0.45439, 0.96382, -1.46000)),
)  # fmt: skip


def impulses(name: str, f: float, zeta: float) -> tuple[np.ndarray, np.ndarray]:
    """A, T of a shaper for one vibration, each of shape (n,). Raises ModelError where the damping is beyond it."""
    if not 0 <= zeta <= MAX_DAMPING[name]:
        raise ModelError(f"shaper {name} needs a damping ratio of at most {MAX_DAMPING[name]:g}, the mode has "
                         f"{zeta:.3g}; take zv, mzv or zvd")  # fmt: skip
    period = 1 / (f * sqrt(1 - zeta**2))
    K = exp(-zeta * pi / sqrt(1 - zeta**2))
    A: Sequence[float] | np.ndarray
    T: Sequence[float] | np.ndarray
    if name == "zv":
        A, T = [1, K], [0, 0.5 * period]
    elif name == "zvd":
        A, T = [1, 2 * K, K**2], [0, 0.5 * period, period]
    elif name == "mzv":  # zeros at f and 5/3 f, three quarters of a period long
        K = K**0.75
        A, T = [1 - sqrt(0.5), (sqrt(2) - 1) * K, (1 - sqrt(0.5)) * K**2], [0, 0.375 * period, 0.75 * period]
    elif name == "ei":
        A, T = _extra_insensitive(zeta, period)
    else:
        times, weights = TWO_HUMP if name == "2hump_ei" else THREE_HUMP
        A, T = polyval(zeta, np.transpose(weights)), polyval(zeta, np.transpose(times)) / f
    return np.divide(A, np.sum(A)), np.array(T, float)


def _extra_insensitive(zeta: float, period: float) -> tuple[np.ndarray, np.ndarray]:
    """EI weights and times fitted by powers of zeta and the tolerated vibration, as Klipper has them."""
    v = V_TOL
    first = polyval(zeta, (0.24968 + 0.24961 * v, 0.80008 + 1.23328 * v, 0.49599 + 3.17316 * v))
    third = polyval(zeta, (0.25149 + 0.21474 * v, -0.83249 + 1.41498 * v, 0.85181 - 4.90094 * v))
    middle = polyval(zeta, (0.4999, (0.46159 + 8.57843 * v) * v, (4.26169 - 108.644 * v) * v,
                            (1.75601 + 336.989 * v) * v))  # fmt: skip
    return np.array([first, 1 - first - third, third]), np.array([0.0, middle * period, period])


def shaper(name: str, vibrations: Sequence[tuple[float, float]], dt: float) -> FirCompensator:
    """The named shaper for one (f, zeta) per axis at period dt [s]. Raises ModelError: see `impulses`."""
    made = [impulses(name, f, zeta) for f, zeta in vibrations]
    offsets = [(T - A @ T) / dt for A, T in made]
    lead = max(int(np.ceil(-t.min())) for t in offsets) + AT_REST
    tail = max(int(np.ceil(t.max())) for t in offsets) + AT_REST
    taps = np.zeros((len(made), lead + tail + 2))
    for row, (A, _), t in zip(taps, made, offsets, strict=True):
        j = np.floor(t + lead).astype(int)
        part = t + lead - j
        np.add.at(row, j, A * (1 - part))
        np.add.at(row, j + 1, A * part)
    taps = taps[:, :-1]  # the last column is zero: a whole offset has no right neighbour
    return FirCompensator(name, taps, lead, tail)
