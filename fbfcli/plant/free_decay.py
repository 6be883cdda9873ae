"""Modes from a capture of a machine that rings by itself: after a stop, a tap, a pluck.

y(t) = sum_i a_i e^(-zeta_i w_i t) cos(w_i sqrt(1 - zeta_i^2) t + phi_i)
Frequencies and dampings are found; gains are not, for what set the machine ringing is not known. They are taken in
proportion to the amplitudes a_i of acceleration, which is right after a step of acceleration: the end of a move.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq
from scipy.optimize import least_squares
from scipy.signal import decimate

from fbfcli.errors import ModelError
from fbfcli.plant.intervals import Interval, ModeEstimate, of_logarithm
from fbfcli.plant.model import realised
from fbfcli.plant.rational import Rational, Resonance

RATE_HZ = 700.0  # enough for printers' modes; a capture is brought down to it
LEAST_HZ, MOST_HZ = 8.0, 250.0
DAMPING = (2e-3, 0.3)
MOST_MODES = 3
LONGEST_S = 1.5
EXPLAINED = 0.5  # of the power of the capture: less is no ringing
FAINT = 0.1  # of the largest amplitude: smaller ones are no modes
FALL = 0.5  # of the rms, from the first third of the capture to the last: what does not fall is driven


@dataclass(frozen=True)
class FreeDecay:
    """A ringing machine: model with assumed gains, modes with intervals, part of the power explained.

    t, y, fitted : ndarray, shape (n,)   [s], [mm/s^2]: what was fitted, and the fit
    """

    model: Rational
    modes: tuple[ModeEstimate, ...]
    explained: float
    t: np.ndarray
    y: np.ndarray
    fitted: np.ndarray


def free_decay(measured: np.ndarray, fs: float) -> FreeDecay:
    """The modes of a capture, shape (n,), from its largest swing on. Raises ModelError where nothing rings down."""
    factor = max(1, int(fs / RATE_HZ))
    y = decimate(measured - measured.mean(), factor, ftype="fir") if factor > 1 else measured - measured.mean()
    fs /= factor
    y = y[int(np.argmax(np.abs(y[: len(y) // 2]))) :][: int(LONGEST_S * fs)]
    third = len(y) // 3
    if third < 20:
        raise ModelError("too short to show how it rings down")
    if np.std(y[-third:]) > FALL * np.std(y[:third]):
        raise ModelError("it does not ring down: it is driven, or still, and nothing is known of the command")
    t = np.arange(len(y)) / fs
    p, r = realised(np.concatenate(([0.0], y)))
    s = np.log(p.astype(complex)) * fs
    w, zeta = np.abs(s), -s.real / np.abs(s)
    good = (
        (s.imag > 0)
        & (w > 2 * np.pi * LEAST_HZ)
        & (w < 2 * np.pi * MOST_HZ)
        & (zeta > DAMPING[0])
        & (zeta < DAMPING[1])
    )
    order = np.argsort(-(np.abs(r) ** 2 / np.maximum(1 - np.abs(p) ** 2, 1e-6))[good])[:MOST_MODES]
    if not len(order):
        raise ModelError("no mode between 8 and 250 Hz rings in it")
    fit = _refined(t, y, w[good][order], zeta[good][order])
    kept = [r for r in fit.model.resonances if r.gain > FAINT * max(one.gain for one in fit.model.resonances)
            and DAMPING[0] < r.damping < 0.99 * DAMPING[1] and LEAST_HZ < r.frequency < MOST_HZ]  # fmt: skip
    if not kept:
        raise ModelError("no mode between 8 and 250 Hz rings in it")
    if len(kept) < len(order):
        fit = _refined(t, y, 2 * np.pi * np.array([r.frequency for r in kept]), np.array([r.damping for r in kept]))
    if fit.explained < EXPLAINED:
        raise ModelError(
            f"decaying modes explain {100 * fit.explained:.0f} % of it: something else moved the machine"
        )
    return fit


def _refined(t: np.ndarray, y: np.ndarray, w: np.ndarray, zeta: np.ndarray) -> FreeDecay:
    """Least squares on the samples; amplitudes and phases are linear and solved for inside."""
    n = len(w)

    def fitted(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        waves = np.exp(np.outer(t, np.exp(x[:n]) * (-np.exp(x[n:]) + 1j * np.sqrt(1 - np.exp(2 * x[n:])))))
        A = np.hstack((waves.real, waves.imag))
        c = lstsq(A, y, check_finite=False)[0]
        return A @ c, np.hypot(c[:n], c[n:])

    low = np.concatenate((np.log(0.8 * w), np.full(n, np.log(DAMPING[0] / 2))))
    high = np.concatenate((np.log(1.25 * w), np.full(n, np.log(DAMPING[1]))))
    start = np.clip(np.concatenate((np.log(w), np.log(zeta))), low + 1e-6, high - 1e-6)
    found = least_squares(lambda x: fitted(x)[0] - y, start,
                          bounds=(low, high), max_nfev=100)  # fmt: skip
    curve, amplitude = fitted(found.x)
    explained = 1 - float(np.var(y - curve) / np.var(y))
    cov = np.linalg.pinv(found.jac.T @ found.jac) * float(np.sum((y - curve) ** 2)) / max(len(y) - 4 * n, 1)
    spread = np.sqrt(np.diag(cov))
    f, damping, gain = np.exp(found.x[:n]) / (2 * np.pi), np.exp(found.x[n:]), amplitude / amplitude.sum()
    order = np.argsort(-gain / damping)
    modes = [
        ModeEstimate(of_logarithm(float(f[i]), float(spread[i])), of_logarithm(float(damping[i]), float(spread[n + i])),
                     Interval(float(gain[i]), 0.0, 1.0))
        for i in order
    ]  # fmt: skip
    model = Rational(tuple(Resonance(float(f[i]), float(damping[i]), float(gain[i])) for i in order))
    return FreeDecay(model, tuple(modes), explained, t, y, curve)
