"""Machines whose response is known, and responses as a measurement would give them."""

from __future__ import annotations

import numpy as np

from fbfcli.plant.excitation import acceleration
from fbfcli.plant.frf import Frf
from fbfcli.plant.klipper_test import klipper_test
from fbfcli.plant.rational import Lag, Rational, Resonance, response

ONE = Rational((Resonance(38.0, 0.05),))
TWO = Rational((Resonance(30.0, 0.06, 0.7), Resonance(55.0, 0.04, 0.3)))
LAGGING = Rational((Resonance(42.0, 0.1, 0.6, -0.2), Resonance(66.0, 0.04, 0.05, 0.02)), (Lag(500.0, 0.35),))
FS = 1600.0
LINES = 160


def frf_of(model: Rational, noise: float, rng: np.random.Generator, gain: float = 1.0, delay: float = 0.0) -> Frf:
    """The response of a model on LINES lines, with random errors of a given part of |H|."""
    f = np.geomspace(5.0, 130.0, LINES)
    H = gain * np.exp(-2j * np.pi * f * delay) * response(model, f)
    sd = noise * np.abs(H)
    seen = H + sd * (rng.standard_normal(LINES) + 1j * rng.standard_normal(LINES))
    gamma2 = np.full(LINES, 1 / (1 + 2 * 20 * noise**2))
    return Frf(f, np.full(LINES, 1e-3), seen, gamma2, sd, np.full(LINES, 20.0), np.ones(LINES))


def swept(model: Rational, noise: float, rng: np.random.Generator, f1: float = 100.0) -> tuple[np.ndarray, np.ndarray]:
    """Command and response of Klipper's test, at FS; noise is a part of the response's rms."""
    sweep = klipper_test(f1=f1)
    t = np.arange(int((sweep.duration + 2.0) * FS)) / FS - 0.5
    x = acceleration(sweep, t, 1 / FS)
    n = 2 * len(x)
    y = np.fft.irfft(np.fft.rfft(x, n) * response(model, np.fft.rfftfreq(n, 1 / FS)), n)[: len(x)]
    return x, y + noise * y.std() * rng.standard_normal(len(y))
