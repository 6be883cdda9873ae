"""How sure a fit is of its numbers: a covariance of theta from what the fit leaves over, and intervals from it.

Weights of the fit are not what the noise is: they tolerate that no machine is linear. So cov = A^-1 B A^-1 with
A = J^T W J + prior and B = J^T W V W J, V the random error of the lines, scaled until it explains the residuals, and by
the number of neighbouring lines that say the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.fit import Candidate, correlation_length, deviation, neighbours_mean, prior
from fbfcli.plant.frf import Frf
from fbfcli.plant.rational import Rational
from fbfcli.plant.shape import OUTSIDE, model_of

NORMAL_95 = 1.96
LEAST_ERROR = 1e-3  # of |H|: random errors below it are not believed: clocks, rounding


@dataclass(frozen=True)
class Interval:
    """A value and where it lies with 95 % confidence."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class ModeEstimate:
    """One resonance of a fit: frequency [Hz], damping, gain."""

    frequency: Interval
    damping: Interval
    gain: Interval


def covariance(frf: Frf, best: Candidate) -> np.ndarray:
    """Of theta, shape (size, size)."""
    J, r, sd = best.derivatives, best.residual, deviation(frf)
    v = (neighbours_mean(2 * frf.sd**2) + (LEAST_ERROR * np.abs(frf.H)) ** 2) / sd**2
    dof = max(1.0, len(r) - best.shape.size / 2)
    scale = float(np.sum(np.abs(r) ** 2 / v)) / dof * correlation_length(r / np.sqrt(v))
    _, known = prior(best.shape, best.theta, frf)
    A = (J.conj().T @ J).real + known.T @ known
    B = 0.5 * scale * ((J.conj().T * v) @ J).real + known.T @ known
    inverse = np.linalg.pinv(A, hermitian=True)
    return np.asarray(inverse @ B @ inverse)


def mode_estimates(best: Candidate, cov: np.ndarray) -> tuple[ModeEstimate, ...]:
    """The resonances, strongest peak (gain by damping) first."""
    shape, model = best.shape, model_of(best.shape, best.theta)
    found, at = [], OUTSIDE
    for i, r in enumerate(model.resonances):
        spread = np.sqrt(np.diag(cov))
        by_theta = np.zeros(shape.size)
        if i > 0:
            by_theta[at + 2] = 1.0
        else:
            by_theta[gain_places(shape)] = -1.0
        gain = float(np.sqrt(by_theta @ cov @ by_theta))
        found.append(
            ModeEstimate(
                _of_logarithm(r.frequency, float(spread[at])),
                _of_logarithm(r.damping, float(spread[at + 1])),
                Interval(r.gain, r.gain - NORMAL_95 * gain, r.gain + NORMAL_95 * gain),
            )
        )
        at += (4 if shape.general else 3) - (i == 0)
    heights = [np.hypot(r.gain, r.slope) / r.damping for r in model.resonances]
    return tuple(found[i] for i in np.argsort(heights)[::-1])


def gain_places(shape) -> list[int]:  # type: ignore[no-untyped-def]
    """Where theta holds the gains that are not the first's."""
    step = 4 if shape.general else 3
    lags = shape.size - 2 * shape.lags
    return [OUTSIDE + i * step + 1 for i in range(1, shape.pairs)] + [lags + 2 * j + 1 for j in range(shape.lags)]


def draws(best: Candidate, cov: np.ndarray, count: int, rng: np.random.Generator) -> tuple[Rational, ...]:
    """Models as probable as the measurement leaves them."""
    return tuple(model_of(best.shape, theta) for theta in rng.multivariate_normal(best.theta, cov, count))


def _of_logarithm(value: float, spread: float) -> Interval:
    factor = float(np.exp(NORMAL_95 * min(spread, 10.0)))
    return Interval(value, value / factor, value * factor)
