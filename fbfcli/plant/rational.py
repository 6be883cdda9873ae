"""A stable rational model in continuous time: a sum of resonances and lags, each of its own poles.

H(s) = sum_i (c_i w_i^2 + e_i w_i s) / (s^2 + 2 zeta_i w_i s + w_i^2) + sum_j g_j p_j / (s + p_j)
sum c_i + sum g_j = 1
Zeros may lie anywhere; the poles are stable because zeta and p are positive; position follows the command at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.model import first_order_hold
from fbfcli.printer import ModalModel, Mode, TransferFunction

DIGITS = 6  # significant, of a number in a profile


@dataclass(frozen=True)
class Resonance:
    """An oscillating pole pair: frequency [Hz], damping, gain c and slope e (0 in a plain mode)."""

    frequency: float
    damping: float
    gain: float = 1.0
    slope: float = 0.0


@dataclass(frozen=True)
class Lag:
    """A real pole: its rate [1/s] and gain g."""

    rate: float
    gain: float


@dataclass(frozen=True)
class Rational:
    """Resonances and lags whose gains sum to 1."""

    resonances: tuple[Resonance, ...]
    lags: tuple[Lag, ...] = ()

    @property
    def is_modal(self) -> bool:
        """A sum of plain modes: what a profile calls `modes`."""
        return not self.lags and all(r.slope == 0.0 for r in self.resonances)


def response(model: Rational, frequency: np.ndarray) -> np.ndarray:
    """H at each frequency [Hz], complex, of the frequencies' shape."""
    s = 2j * np.pi * frequency
    H = np.zeros(s.shape, complex)
    for r in model.resonances:
        w = 2 * np.pi * r.frequency
        H += (r.gain * w**2 + r.slope * w * s) / (s**2 + 2 * r.damping * w * s + w**2)
    for lag in model.lags:
        H += lag.gain * lag.rate / (s + lag.rate)
    return H


def polynomials(model: Rational) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator in s, highest power first."""
    parts = [
        (np.array([r.slope * w, r.gain * w**2]), np.array([1.0, 2 * r.damping * w, w**2]))
        for r in model.resonances
        for w in [2 * np.pi * r.frequency]
    ] + [(np.array([lag.gain * lag.rate]), np.array([1.0, lag.rate])) for lag in model.lags]
    b: np.ndarray = np.zeros(1)
    a: np.ndarray = np.ones(1)
    for num, den in parts:
        b, a = np.polyadd(np.polymul(b, den), np.polymul(num, a)), np.polymul(a, den)
    return b, a


def zeros(model: Rational) -> np.ndarray:
    """Zeros in s [rad/s], complex; those with a positive real part make an inverse unstable (non-minimum phase)."""
    b, _ = polynomials(model)
    return np.roots(b)


def discretised(model: Rational, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """b, a of z^0, z^-1, ... for a command that is linear between samples dt [s] apart, as a planner's is."""
    parts = [*(Rational((r,)) for r in model.resonances), *(Rational((), (lag,)) for lag in model.lags)]
    return first_order_hold(map(polynomials, parts), dt)


def profile_model(model: Rational, dt: float) -> ModalModel | TransferFunction:
    """The model as a printer profile holds it: `modes` where it is a sum of plain modes, else b, a at period dt [s].

    Gains are rounded so that they still sum to 1; coefficients are not: poles near the unit circle need them all.
    """
    if model.is_modal:
        rounded = [float(f"{r.gain:.{DIGITS}g}") for r in model.resonances]
        rounded[-1] = round(1.0 - sum(rounded[:-1]), 12)
        return ModalModel(
            tuple(
                Mode(float(f"{r.frequency:.{DIGITS}g}"), float(f"{r.damping:.{DIGITS}g}"), gain)
                for r, gain in zip(model.resonances, rounded, strict=True)
            )
        )
    b, a = discretised(model, dt)
    return TransferFunction(tuple(map(float, b)), tuple(map(float, a)), dt)
