"""The shape of a rational model: how many poles of which kind, and the vector of numbers a fit turns.

theta = [ln G, tau, kappa, then per resonance ln w, ln zeta, (c), (e), then per lag ln p, g]
M(s)  = G e^(-s (tau + kappa f)) H(s)     G, tau, kappa: what the sensor and the alignment of clocks add; they are no
part of the machine. A clock that is off by epsilon delays a sweep's later, higher frequencies more: kappa f.
The gain c of the first resonance is left out: the gains sum to 1. A modal shape has no slopes e.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.rational import Lag, Rational, Resonance

OUTSIDE = 3  # entries of theta that are not the machine's: ln G, tau, kappa


@dataclass(frozen=True)
class Shape:
    """Resonances, lags, and whether the numerator is general (zeros anywhere) or that of a sum of modes."""

    pairs: int
    lags: int = 0
    general: bool = False

    @property
    def size(self) -> int:
        """Length of theta."""
        return OUTSIDE + self.pairs * (4 if self.general else 3) - 1 + 2 * self.lags

    def __str__(self) -> str:
        lags = {0: "", 1: " + 1 lag"}.get(self.lags, f" + {self.lags} lags")
        modes = f"{self.pairs} mode{'s' if self.pairs > 1 else ''}"
        return f"{modes}{lags}{', free zeros' if self.general else ''}"


def model_of(shape: Shape, theta: np.ndarray) -> Rational:
    """The machine that a vector describes."""
    w, zeta, c, e, rate, g = _parts(shape, theta)
    return Rational(
        tuple(Resonance(*map(float, row)) for row in zip(w / (2 * np.pi), zeta, c, e, strict=True)),
        tuple(Lag(*map(float, row)) for row in zip(rate, g, strict=True)),
    )


def vector_of(shape: Shape, model: Rational, gain: float, delay: float, drift: float = 0.0) -> np.ndarray:
    """The vector of a model, shape (shape.size,)."""
    theta = [np.log(gain), delay, drift]
    for i, r in enumerate(model.resonances):
        theta += [np.log(2 * np.pi * r.frequency), np.log(r.damping)]
        theta += [r.gain] * (i > 0) + [r.slope] * shape.general
    for lag in model.lags:
        theta += [np.log(lag.rate), lag.gain]
    return np.array(theta)


def measured_response(shape: Shape, theta: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """M at s, shape (m,), and its derivatives by theta, shape (m, size)."""
    w, zeta, c, e, rate, g = _parts(shape, theta)
    f = s.imag / (2 * np.pi)
    outside = np.exp(theta[0] - s * (theta[1] + theta[2] * f))
    H, columns, by_first_gain = np.zeros(len(s), complex), [], None
    for w_i, zeta_i, c_i, e_i in zip(w, zeta, c, e, strict=True):
        D = s**2 + 2 * zeta_i * w_i * s + w_i**2
        part = (c_i * w_i**2 + e_i * w_i * s) / D
        H = H + part
        columns.append((2 * c_i * w_i**2 + e_i * w_i * s - part * (2 * zeta_i * w_i * s + 2 * w_i**2)) / D)
        columns.append(-part * 2 * zeta_i * w_i * s / D)
        by_gain = w_i**2 / D
        if by_first_gain is None:
            by_first_gain = by_gain
        else:
            columns.append(by_gain - by_first_gain)
        if shape.general:
            columns.append(w_i * s / D)
    for p, g_j in zip(rate, g, strict=True):
        H = H + g_j * p / (s + p)
        columns += [g_j * p * s / (s + p) ** 2, p / (s + p) - by_first_gain]
    derivatives = np.column_stack([H, -s * H, -s * f * H, *columns]) * outside[:, None]
    return H * outside, derivatives


def delay_at_rest(shape: Shape, theta: np.ndarray) -> tuple[float, np.ndarray]:
    """Group delay of H at 0 Hz, sum (2 zeta c - e) / w + sum g / p [s], and its derivatives by theta, shape (size,)."""
    w, zeta, c, e, rate, g = _parts(shape, theta)
    first = 2 * zeta[0] / w[0]
    rows = []
    for i, (w_i, zeta_i, c_i, e_i) in enumerate(zip(w, zeta, c, e, strict=True)):
        rows += [-(2 * zeta_i * c_i - e_i) / w_i, 2 * zeta_i * c_i / w_i]
        rows += [2 * zeta_i / w_i - first] * (i > 0) + [-1 / w_i] * shape.general
    for p, g_j in zip(rate, g, strict=True):
        rows += [-g_j / p, 1 / p - first]
    return float(np.sum((2 * zeta * c - e) / w) + np.sum(g / rate)), np.array([*[0.0] * OUTSIDE, *rows])


def _parts(shape: Shape, theta: np.ndarray) -> tuple[np.ndarray, ...]:
    """w, zeta, c, e of the resonances; rate, g of the lags."""
    n = 4 if shape.general else 3
    end = len(theta) - 2 * shape.lags
    rows = np.insert(theta[OUTSIDE:end], 2, 0.0).reshape(shape.pairs, n)  # the first gain's place
    rate, g = theta[end:].reshape(shape.lags, 2).T
    c = rows[:, 2].copy()
    c[0] = 1.0 - c[1:].sum() - g.sum()
    e = rows[:, 3] if shape.general else np.zeros(shape.pairs)
    return np.exp(rows[:, 0]), np.exp(rows[:, 1]), c, e, np.exp(rate), g
