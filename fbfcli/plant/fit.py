"""From a measured frequency response to a stable model: vector fitting, then least squares on the complex response.

What the sensor and the clocks add is fitted beside the machine and left out of the model: a gain G (an accelerometer's
scale is known to some per cent) and a pure delay tau (two clocks were aligned to a few samples). They can be told from
the machine because its response is rational with unit gain at rest: each resonance turns the phase by as much as
its magnitude says, and what turns it in proportion to frequency beyond that is delay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.linalg import lstsq
from scipy.optimize import least_squares

from fbfcli.errors import ModelError
from fbfcli.plant.candidate import DECISIVE, Candidate, chosen_first, ranked
from fbfcli.plant.frf import Frf
from fbfcli.plant.rational import Lag, Rational, Resonance, response
from fbfcli.plant.shape import OUTSIDE, Shape, delay_at_rest, measured_response, model_of, vector_of
from fbfcli.plant.vector_fitting import fit_poles, starting_poles

MOST_MODES = 4
MODEL_ERROR = (0.003, 0.05)  # of |H|, least and most: no machine is linear to better, none worth a model to worse
DELAYS_S = np.linspace(-0.01, 0.01, 41)  # tried to start from
GAINS = (0.7, 1.4)  # of a sensor
SENSOR_GAIN = 0.1  # the ADXL345's sensitivity is known to 10 %, and mountings tilt
DAMPING = (1e-3, 0.95)
SLOWEST_DECAY = 0.7  # 1/s: what rings longer is no machine, and more than a compensator's 20 s of memory
LEAST_LINES = 12
STARTS = 3  # that are refined, of those at all delays
# Delay and zeros outside the left half plane imitate each other. Where the response cannot tell them apart, what turns
# the phase is delay: a machine's own at rest is about 2 zeta / w, some milliseconds (6.4 ms of the TAZ 6; 1 ms here
# pulled its modes 0.1 % apart)
PLAIN_DELAY_S = 3e-3
FASTER, WEAK = 4.0, (0.02, -0.02)  # a lag that is added begins so much faster than the band, with these gains
SMOOTH = 5  # lines whose random errors are averaged: of a few averages each is itself uncertain
GAUSS = (
    np.array([-1, 0, 1]) * np.sqrt(0.15),
    np.array([5, 8, 5]) / 18,
)  # three points for the mean over a line's width
RISE = 1.5  # times the largest measured magnitude: a model that rises higher outside the band invents a resonance


def candidates(frf: Frf) -> tuple[Candidate, ...]:
    """Shapes that the response supports, fitted: the chosen one first, then by criterion.

    Modes are added as long as they pay. The chosen one is the smallest within DECISIVE of the best criterion.
    Raises ModelError where no model fits.
    """
    m = len(frf.frequency)
    if m < LEAST_LINES:
        raise ModelError(f"the command excites {m} lines of the spectrum; {LEAST_LINES} are needed to fit a model")
    sd = deviation(frf)
    found: list[Candidate] = []
    delays = DELAYS_S
    for pairs in range(1, MOST_MODES + 1):
        for shape in shapes(pairs):
            if 2 * m >= 3 * shape.size and (best := _fitted(frf, sd, shape, delays)) is not None:
                found.append(best)
                delays = np.concatenate((best.theta[1] + DELAYS_S[::4], DELAYS_S[::4]))
                if shape == shapes(pairs)[-1] and (more := _with_faster_lag(frf, sd, best)) is not None:
                    found.append(more)
        found = ranked(found)
        fewer, now = (min((c.criterion for c in found if (c.shape.pairs == pairs) == same), default=np.inf)
                      for same in (False, True))  # fmt: skip
        if now > fewer - DECISIVE:
            break
    if not found:
        raise ModelError(
            "no stable model with modes inside the measured band fits: give a wider --band, or shake harder"
        )
    return chosen_first(found)


def candidates_again(frf: Frf, found: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """The same shapes, each fitted from where it was, to a response that differs little from the one before."""
    sd = deviation(frf)
    again = (refitted(frf, one, sd) for one in found)
    return chosen_first(ranked([one for one in again if _plausible(one.shape, one.theta, frf)])) or tuple(found)


def refitted(frf: Frf, near: Candidate, sd: np.ndarray | None = None) -> Candidate:
    """One of them."""
    sd = deviation(frf) if sd is None else sd
    return _candidate(frf, sd, near.shape, _refined(frf, sd, near.shape, near.theta).x)


def best_of_shape(frf: Frf, shape: Shape, delay: float) -> Candidate | None:
    """One shape fitted, beginning near a delay that is known [s]; None where the response does not support it."""
    if 2 * len(frf.frequency) < 3 * shape.size:
        return None
    return _fitted(frf, deviation(frf), shape, delay + DELAYS_S[::4])


def nearer(frf: Frf, near: Candidate) -> Candidate:
    """The same shape fitted to a part of what it was fitted to, or as it was where the part does not support it."""
    return refitted(frf, near) if 2 * len(frf.frequency) >= 3 * near.shape.size else near


def shapes(pairs: int) -> tuple[Shape, ...]:
    """Shapes with this many resonances, smallest first."""
    return tuple(Shape(pairs, lags, general) for general in (False, True) for lags in (0, 1))


def deviation(frf: Frf) -> np.ndarray:
    """Standard deviation of H, shape (m,): random error, averaged over neighbours, and the error of any model.

    That is taken as large as neighbouring lines differ, for a machine's response is smooth: what friction and backlash
    make of it is not, and keeps the best lines from deciding everything.
    """
    size = np.abs(frf.H)
    rough = np.abs(frf.H[:-2] - 2 * frf.H[1:-1] + frf.H[2:]) / np.sqrt(6) / np.maximum(size[1:-1], 1e-9)
    part = float(np.clip(np.median(rough), *MODEL_ERROR))
    return np.sqrt(neighbours_mean(2 * frf.sd**2) + (part * size) ** 2 + 1e-8 * np.mean(size) ** 2)


def neighbours_mean(values: np.ndarray, count: int = SMOOTH) -> np.ndarray:
    """Values averaged over some neighbouring lines."""
    kernel = np.ones(min(count, len(values)))
    return np.convolve(values, kernel, "same") / lines_within(len(values), count)


def lines_within(n: int, count: int) -> np.ndarray:
    """How many of n lines are among `count` neighbours of each, shape (n,): fewer at the ends."""
    return np.convolve(np.ones(n), np.ones(min(count, n)), "same")


def averaged(shape: Shape, theta: np.ndarray, frf: Frf) -> tuple[np.ndarray, np.ndarray]:
    """Model and derivatives as a line of the spectrum shows them: the mean over its width."""
    if not frf.width.any():
        return measured_response(shape, theta, 2j * np.pi * frf.frequency)
    offsets, weights = GAUSS
    at = [measured_response(shape, theta, 2j * np.pi * (frf.frequency + frf.width * o)) for o in offsets]
    M = sum(w * M_i for w, (M_i, _) in zip(weights, at, strict=True))
    J = sum(w * J_i for w, (_, J_i) in zip(weights, at, strict=True))
    return np.asarray(M), np.asarray(J)


def _fitted(frf: Frf, sd: np.ndarray, shape: Shape, delays: np.ndarray) -> Candidate | None:
    """The best of refinements from the best starts; None where the shape has nothing to hold on to."""
    starts = sorted((_start(frf, sd, shape, tau) for tau in delays), key=lambda start: start[0])[:STARTS]
    best, cost = None, np.inf
    for _, theta in starts:
        solution = _refined(frf, sd, shape, theta)
        if solution.cost < cost and _plausible(shape, solution.x, frf):
            best, cost = solution.x, solution.cost
    return None if best is None else _candidate(frf, sd, shape, best)


def _with_faster_lag(frf: Frf, sd: np.ndarray, fitted: Candidate) -> Candidate | None:
    """One lag more than was fitted, begun fast and weak.

    What a machine and its hold do above the band is seen within it as a nearly constant residual (Ewins, Modal Testing,
    Sec. 4.3). Of the TAZ 6, a filter at 1 kHz, it is 0.3 % of the response; left out, dampings come out 2 % off.
    """
    shape = replace(fitted.shape, lags=fitted.shape.lags + 1)
    if 2 * len(frf.H) < 3 * shape.size:
        return None
    rate = np.log(2 * np.pi * FASTER * frf.frequency[-1])
    solutions = [_refined(frf, sd, shape, np.append(fitted.theta, (rate, gain))) for gain in WEAK]
    plausible = [solution for solution in solutions if _plausible(shape, solution.x, frf)]
    if not plausible:
        return None
    return _candidate(frf, sd, shape, min(plausible, key=lambda solution: float(solution.cost)).x)


def _candidate(frf: Frf, sd: np.ndarray, shape: Shape, theta: np.ndarray) -> Candidate:
    """A shape with its theta, and what it leaves over."""
    M, J = averaged(shape, theta, frf)
    misfit = np.sqrt(np.mean(np.abs(frf.H - M) ** 2) / np.mean(np.abs(frf.H) ** 2))
    return Candidate(shape, theta, (frf.H - M) / sd, J / sd[:, None], float(misfit))


def _start(frf: Frf, sd: np.ndarray, shape: Shape, tau: float) -> tuple[float, np.ndarray]:
    """Cost and theta: poles by vector fitting of the response without this delay, then gains by linear fit."""
    s = 2j * np.pi * frf.frequency
    band = float(frf.frequency[0]), float(frf.frequency[-1])
    H = frf.H * np.exp(s * tau)
    poles = fit_poles(s, H, 1 / sd, starting_poles(shape.pairs, shape.lags, band))
    poles = _of_shape(poles, shape, band)
    w, zeta = (
        np.abs(poles[: shape.pairs]),
        np.clip(-poles[: shape.pairs].real / np.abs(poles[: shape.pairs]), *DAMPING),
    )
    rate = np.clip(-poles[shape.pairs :].real, 2 * np.pi * band[0], 4 * np.pi * band[1])
    D = s[:, None] ** 2 + 2 * zeta * w * s[:, None] + w**2
    columns = [w**2 / D, *([w * s[:, None] / D] if shape.general else []), rate / (s[:, None] + rate)]
    A = np.hstack(columns) / sd[:, None]
    right = H / sd
    x = lstsq(np.vstack((A.real, A.imag)), np.concatenate((right.real, right.imag)), check_finite=False)[0]
    left = right - A @ x
    c, e, g = x[: shape.pairs], x[shape.pairs :][: shape.pairs * shape.general], x[len(x) - shape.lags :]
    G = np.clip(c.sum() + g[: shape.lags].sum(), *GAINS)
    e = e if shape.general else np.zeros(shape.pairs)
    resonances = [Resonance(*row) for row in zip(w / (2 * np.pi), zeta, c / G, e / G, strict=True)]
    lags = [Lag(*row) for row in zip(rate, g / G, strict=True)] if shape.lags else []
    return float(np.vdot(left, left).real), vector_of(shape, Rational(tuple(resonances), tuple(lags)), G, tau)


def _of_shape(poles: np.ndarray, shape: Shape, band: tuple[float, float]) -> np.ndarray:
    """Upper poles of the pairs, then lags, as many as the shape has: vector fitting may have paired real ones."""
    upper, real = poles[poles.imag > 0], poles[poles.imag == 0]
    missing = shape.pairs - len(upper)
    if missing > 0:  # two real poles become one well damped pair
        w = np.clip(np.abs(real[: 2 * missing : 2]), 2 * np.pi * band[0], 2 * np.pi * band[1])
        w = np.concatenate((w, np.full(missing - len(w), np.pi * sum(band))))
        upper, real = np.concatenate((upper, w * (-0.5 + 0.866j))), real[2 * missing :]
    spare = upper[shape.pairs :]
    lags = np.concatenate((real, -np.abs(spare), np.full(shape.lags, -2 * np.pi * band[1])))[: shape.lags]
    return np.concatenate((upper[: shape.pairs], lags))


def _refined(frf: Frf, sd: np.ndarray, shape: Shape, theta: np.ndarray):  # type: ignore[no-untyped-def]
    """scipy's solution of least squares on real and imaginary parts, within what a machine and a sensor can be."""

    @lru_cache(maxsize=1)  # the solver asks for residual and Jacobian of the same theta one after the other
    def at(x: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        M, J = averaged(shape, np.array(x), frf)
        r, J = (M - frf.H) / sd, J / sd[:, None]
        known, by_theta = prior(shape, np.array(x), frf)
        return np.concatenate((r.real, r.imag, known)), np.vstack((J.real, J.imag, by_theta))

    low, high = bounds(shape, frf)
    start = np.clip(theta, low + 1e-9, high - 1e-9)
    return least_squares(
        lambda x: at(tuple(x))[0], start, lambda x: at(tuple(x))[1], bounds=(low, high), x_scale="jac", max_nfev=60
    )


def prior(shape: Shape, theta: np.ndarray, frf: Frf) -> tuple[np.ndarray, np.ndarray]:
    """What is known before the measurement, in standard deviations, shape (4,), and its derivatives: (4, size)."""
    delay, by_theta = delay_at_rest(shape, theta)
    known = np.eye(shape.size)[:OUTSIDE] / np.array([[SENSOR_GAIN], [np.inf], [max(frf.drift, 1e-12)]])
    return np.concatenate((known @ theta, [delay / PLAIN_DELAY_S])), np.vstack((known, by_theta / PLAIN_DELAY_S))


def bounds(shape: Shape, frf: Frf) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest theta: modes within reach of the measured band, dampings of oscillations."""
    low, high = np.full(shape.size, -np.inf), np.full(shape.size, np.inf)
    low[0], high[0] = np.log(GAINS)
    low[1], high[1] = -0.05, 0.05
    low[2], high[2] = -1e-3, 1e-3
    at, step = OUTSIDE, 4 if shape.general else 3
    for i in range(shape.pairs):
        low[at : at + 2] = np.log(4 * np.pi * frf.frequency[0]), np.log(DAMPING[0])
        high[at : at + 2] = np.log(2.6 * np.pi * frf.frequency[-1]), np.log(DAMPING[1])
        at += step - (i == 0)
    for _ in range(shape.lags):
        low[at], high[at] = np.log(np.pi * frf.frequency[0]), np.log(20 * np.pi * frf.frequency[-1])
        at += 2
    return low, high


def _plausible(shape: Shape, theta: np.ndarray, frf: Frf) -> bool:
    """No mode stuck at a bound, no resonance invented where nothing was measured."""
    low, high = bounds(shape, frf)
    low[:OUTSIDE], high[:OUTSIDE] = -np.inf, np.inf
    high[shape.size - 2 * shape.lags :: 2] = np.inf  # a lag at its fastest is what lies above the band
    stuck = (theta - low < 1e-3) | (high - theta < 1e-3)
    outside = np.concatenate((np.linspace(0, frf.frequency[0], 50), np.linspace(1, 3, 100) * frf.frequency[-1]))
    model = model_of(shape, theta)
    if min(2 * np.pi * r.frequency * r.damping for r in model.resonances) < SLOWEST_DECAY:
        return False
    rise = np.abs(response(model, outside)).max()
    return not stuck.any() and rise < RISE * max(1.0, np.abs(frf.H).max())
