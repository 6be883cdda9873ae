"""How sure a fit is of its numbers: a covariance of theta from what the fit leaves over, and intervals from it.

Weights of the fit are not what the noise is: they tolerate that no machine is linear, and coherence is lost inside a
line where a narrow peak bends the response, which is no noise. So cov = A^-1 B A^-1 with A = J^T J + prior and
B = J^T V J, V what is left over in the neighbourhood of each line, times the number of lines that say the same (White
1980; Long & Ervin 2000, The American Statistician 54).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fbfcli.plant.candidate import DECISIVE, Candidate, correlation_length
from fbfcli.plant.fit import deviation, neighbours_mean, prior
from fbfcli.plant.frf import Frf
from fbfcli.plant.rational import Rational
from fbfcli.plant.shape import OUTSIDE, model_of

NORMAL_95 = 1.96
# Standard deviations of ln f and ln zeta that are left with no noise at all: windows, the sensor's steps, a clock
# found to 1 ppm (benchmarks/identify_truth.py)
FREQUENCY_FLOOR, DAMPING_FLOOR = 1e-5, 1e-4
NEIGHBOURS = 15  # lines whose residuals tell the noise of the one among them


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
    J, r = best.derivatives, best.residual
    _, known = prior(best.shape, best.theta, frf)
    inverse = _inverse((J.conj().T @ J).real + known.T @ known)
    # each line pulls the fit towards itself and so leaves less over: h is its share in its own fit (HC3)
    h = 0.5 * np.einsum("mi,ij,mj->m", J.conj(), inverse, J).real
    # lines a few apart leave over as different parts of |H| as their random errors are: of a peak's it is little
    part = np.maximum(neighbours_mean(2 * frf.sd**2), 1e-300) / deviation(frf) ** 2
    left = np.abs(r / np.maximum(1 - h, 0.1)) ** 2 / part
    v = part * neighbours_mean(left, NEIGHBOURS) * correlation_length(r)
    B = 0.5 * ((J.conj().T * v) @ J).real + known.T @ known
    return np.asarray(inverse @ B @ inverse)


def _inverse(A: np.ndarray) -> np.ndarray:
    """The inverse of a matrix whose rows have units as different as 1 and seconds per Hz."""
    size = np.sqrt(np.maximum(np.diag(A), 1e-300))
    return np.asarray(np.linalg.pinv(A / np.outer(size, size), hermitian=True) / np.outer(size, size))


def mode_estimates(best: Candidate, cov: np.ndarray) -> tuple[ModeEstimate, ...]:
    """The resonances, strongest peak (gain by damping) first."""
    shape, model = best.shape, model_of(best.shape, best.theta)
    found, at = [], OUTSIDE
    spread = np.sqrt(np.maximum(np.diag(cov), 0.0))
    for i, r in enumerate(model.resonances):
        by_theta = np.zeros(shape.size)
        if i > 0:
            by_theta[at + 2] = 1.0
        else:
            by_theta[gain_places(shape)] = -1.0
        gain = float(np.sqrt(max(by_theta @ cov @ by_theta, 0.0)))  # rounding may leave less than 0
        found.append(
            ModeEstimate(
                of_logarithm(r.frequency, float(np.hypot(spread[at], FREQUENCY_FLOOR))),
                of_logarithm(r.damping, float(np.hypot(spread[at + 1], DAMPING_FLOOR))),
                of_number(r.gain, gain),
            )
        )
        at += (4 if shape.general else 3) - (i == 0)
    heights = [np.hypot(r.gain, r.slope) / r.damping for r in model.resonances]
    return tuple(found[i] for i in np.argsort(heights)[::-1])


def told_modes(frf: Frf, found: Sequence[Candidate]) -> tuple[ModeEstimate, ...]:
    """The chosen fit's modes, the first of `found`, with intervals that hold what the choice of a shape leaves open.

    Shapes of as many modes that the data do not rule out say other values: each weighs exp(-AIC / 2), and
    var = sum_k weight_k (var_k + (value_k - value)^2) (Buckland, Burnham & Augustin 1997, Biometrics 53, Eq. 9).
    By BIC, which chooses, a lag that stands for all above the band would have to be seen to be believed; left out
    where it is there, it moves a well damped mode by several of the chosen fit's own standard deviations.
    """
    best = found[0]
    same = [c for c in found if c.shape.pairs == best.shape.pairs]
    least = min(c.akaike for c in same)
    rivals = [best, *(c for c in same[1:] if c.akaike < least + DECISIVE)]
    weights = np.exp([0.5 * (least - c.akaike) for c in rivals])
    told = [mode_estimates(c, covariance(frf, c)) for c in rivals]
    return tuple(_averaged(told, weights / weights.sum(), mode) for mode in told[0])


def _averaged(told: Sequence[tuple[ModeEstimate, ...]], weights: np.ndarray, mode: ModeEstimate) -> ModeEstimate:
    """One mode with the intervals of several fits, in each of which it is the one nearest in frequency."""
    same = [min(one, key=lambda m: abs(np.log(m.frequency.value / mode.frequency.value))) for one in told]
    return ModeEstimate(
        of_logarithm(mode.frequency.value, _deviation([np.log(_three(m.frequency)) for m in same], weights)),
        of_logarithm(mode.damping.value, _deviation([np.log(_three(m.damping)) for m in same], weights)),
        of_number(mode.gain.value, _deviation([_three(m.gain) for m in same], weights)),
    )


def _deviation(intervals: Sequence[np.ndarray], weights: np.ndarray) -> float:
    """Standard deviation about the first one's value of (value, low, high), each of shape (3,)."""
    value, low, high = np.transpose(intervals)
    return float(np.sqrt(weights @ (((high - low) / (2 * NORMAL_95)) ** 2 + (value - value[0]) ** 2)))


def _three(interval: Interval) -> np.ndarray:
    return np.array([interval.value, interval.low, interval.high])


def gain_places(shape) -> list[int]:  # type: ignore[no-untyped-def]
    """Where theta holds the gains that are not the first's."""
    step = 4 if shape.general else 3
    lags = shape.size - 2 * shape.lags
    return [OUTSIDE + i * step + 1 for i in range(1, shape.pairs)] + [lags + 2 * j + 1 for j in range(shape.lags)]


def draws(best: Candidate, cov: np.ndarray, count: int, rng: np.random.Generator) -> tuple[Rational, ...]:
    """Models as probable as the measurement leaves them."""
    off = rng.multivariate_normal(np.zeros(len(cov)), 0.5 * (cov + cov.T), count, check_valid="ignore", method="eigh")
    # theta holds logarithms and gains: beyond 1 the linear picture that cov is means nothing
    return tuple(model_of(best.shape, best.theta + np.clip(one, -1.0, 1.0)) for one in off)


def of_logarithm(value: float, spread: float) -> Interval:
    """The interval of a number from the standard deviation of its logarithm."""
    factor = float(np.exp(NORMAL_95 * min(spread, 10.0)))
    return Interval(value, value / factor, value * factor)


def of_number(value: float, spread: float) -> Interval:
    """The interval of a number from its standard deviation."""
    return Interval(value, value - NORMAL_95 * spread, value + NORMAL_95 * spread)
