"""A plant: what one axis of the machine makes of its command, as a discrete filter of unit DC gain.

b, a : coefficients of z^0, z^-1, ...      p, r : poles in z and their residues      s = ln(p) / dt
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.linalg import svd
from scipy.signal import cont2discrete, lfilter

from fbfcli.errors import ModelError
from fbfcli.printer import FrequencyResponse, ImpulseResponse, ModalModel, Mode, Model, TransferFunction

DC_TOLERANCE = 0.02  # of rounded coefficients and of measurements; a larger offset is another quantity than position
MARGINAL = 1e-6  # a pole this close to the unit circle rings for millions of samples
LONGEST_S, MAX_SAMPLES = 20.0, 20_000  # of an impulse response, the larger of both: no printer rings that long
TOLERANCE = 1e-5  # of the slowest envelope at the end of an impulse response: 11.5 time constants
TAIL = 0.01  # of an impulse response that may be cut off
RANK = 1e-3  # singular values of a Hankel matrix under this part of the largest are no mode
BA = tuple[np.ndarray, np.ndarray]
HANKEL = 300  # rows of that matrix: 0.6 s of response at 1 ms tell modes apart from 2 Hz on


@dataclass(frozen=True)
class Plant:
    """y = b(z^-1) / a(z^-1) u: stable, unit DC gain, a[0] = 1.

    b, a : ndarray, shapes (nb,), (na,)   coefficients of z^0, z^-1, ...
    dt   : float                          period [s]
    """

    b: np.ndarray
    a: np.ndarray
    dt: float


class Vibration(NamedTuple):
    """One oscillating pole pair: undamped frequency [Hz], damping ratio, height of its own resonance peak."""

    frequency: float
    damping: float
    weight: float


def plant_of(model: Model, dt: float, axis: str) -> Plant:
    """The discrete plant of a printer profile's model at period `dt` [s]; `axis` names it in errors.

    Raises ModelError: unstable or marginal poles, DC gain off one by more than 2 %, non-finite coefficients,
    a period the model cannot be brought to, a response without phase, an impulse response beyond 20,000 samples.
    """
    return _checked(*coefficients(model, dt, axis), dt, axis)


def coefficients(model: Model, dt: float, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """b, a of a model at period `dt` [s], as they come. Raises ModelError."""
    if isinstance(model, ModalModel):
        return first_order_hold(map(_in_s, model.modes), dt)
    if isinstance(model, TransferFunction):
        return _resampled(model, dt, axis)
    if isinstance(model, ImpulseResponse):
        return _resampled_fir(model, dt), np.ones(1)
    return _fir_of_response(model, dt, axis), np.ones(1)


def impulse_response(plant: Plant, tolerance: float = TOLERANCE) -> np.ndarray:
    """h, shape (n,), sum 1, until the slowest pole's envelope has fallen to `tolerance`. Raises ModelError if long."""
    if len(plant.a) == 1:
        return plant.b / plant.b.sum()
    n = _duration(plant.a, tolerance) + len(plant.b)
    if n > _most(plant.dt):
        raise ModelError(f"the impulse response is {n} samples long, more than {_most(plant.dt)}: check the damping")
    h = lfilter(plant.b, plant.a, np.concatenate(([1.0], np.zeros(n - 1))))
    return h / h.sum()


def cut(h: np.ndarray, count: int) -> np.ndarray:
    """The first `count` samples of an impulse response, scaled to sum 1 again.

    Raises ModelError where more than TAIL of it would be lost: a response cut too short makes any compensator wrong.
    """
    lost = float(np.abs(h[count:]).sum() / np.abs(h).sum())
    if lost > TAIL:
        raise ModelError(f"an impulse response of {count} samples leaves out {100 * lost:.1f} % of this plant's "
                         f"{len(h)} samples: take a longer one")  # fmt: skip
    return h[:count] / h[:count].sum()


def modes(plant: Plant) -> tuple[Vibration, ...]:
    """Oscillating poles, strongest resonance |r| / (1 - |p|) first; of a finite response, those of its realisation."""
    p, r = realised(plant.b) if len(plant.a) == 1 else _residues(plant)
    with np.errstate(divide="ignore"):
        s = np.log(p.astype(complex)) / plant.dt
    keep = (p.imag > 1e-9) & (np.abs(p) < 1.0)
    found = [
        Vibration(float(abs(s_i) / (2 * np.pi)), float(-s_i.real / abs(s_i)), float(abs(r_i) / (1 - abs(p_i))))
        for s_i, r_i, p_i in zip(s[keep], r[keep], p[keep], strict=True)
    ]
    return tuple(sorted(found, key=lambda mode: -mode.weight))


def _in_s(mode: Mode) -> BA:
    """Numerator and denominator of one mode."""
    w = 2 * np.pi * mode.frequency
    return np.array([mode.gain * w**2]), np.array([1.0, 2 * mode.damping * w, w**2])


def first_order_hold(parts: Iterable[BA], dt: float) -> tuple[np.ndarray, np.ndarray]:
    """b, a of a sum of parts whose command is linear between samples dt [s] apart, as a planner's command is.

    parts : numerator and denominator in s of each, highest power first; their sum is what is brought to dt
    """
    b: np.ndarray = np.zeros(1)
    a: np.ndarray = np.ones(1)
    for num_s, den_s in parts:
        leading = np.flatnonzero(num_s)
        if not len(leading):  # a part of gain 0 is none, but keeps its poles
            num: np.ndarray = np.zeros(1)
            den = cont2discrete(([1.0], den_s), dt, method="foh")[1]
        else:
            num, den, _ = cont2discrete((np.asarray(num_s)[leading[0] :], den_s), dt, method="foh")
        num = np.ravel(num)
        padded = np.concatenate((np.zeros(len(den) - len(num)), num))
        b, a = np.polyadd(np.polymul(b, den), np.polymul(padded, a)), np.polymul(a, den)
    return b, a


def mean_response(responses: Sequence[np.ndarray], weights: Sequence[float] | np.ndarray) -> np.ndarray:
    """sum_j weights_j h_j of impulse responses of any lengths, as long as the longest."""
    h = np.zeros(max(map(len, responses)))
    for weight, response in zip(weights, responses, strict=True):
        h[: len(response)] += weight * response
    return h


def _resampled(model: TransferFunction, dt: float, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """b, a at period dt with the same step response 1 + sum c_i p_i^(t / model.dt) at the new sample times."""
    b, a = np.array(model.b, float), np.array(model.a, float)
    if not (np.isfinite(b).all() and np.isfinite(a).all() and a[0] != 0 and len(b)):
        raise ModelError(f"axis {axis}: the coefficients b, a must be finite numbers with a[0] not 0")
    b, a = b / a[0], a / a[0]
    if abs(dt / model.dt - 1) < 1e-9:
        return b, a
    p = np.roots(a)
    apart = np.abs(p[:, None] - p + 2 * np.eye(len(p))).min(initial=1.0)
    if len(b) > len(a) or len(p) == 0 or apart < 1e-6 or np.any((np.abs(p.imag) < 1e-12) & (p.real <= 0)):
        raise ModelError(f"axis {axis}: this transfer function of period {model.dt:g} s cannot be brought to {dt:g} s; "
                         f"run at {model.dt:g} s or give modes")  # fmt: skip
    # step response b(z) z / (a(z) (z - 1)): its part at each pole is c_i z / (z - p_i)
    num = np.concatenate((b, np.zeros(len(a) - len(b))))
    c = np.polyval(num, p) / (np.polyval(np.polyder(a), p) * (p - 1))
    q = p ** (dt / model.dt)
    gain = num.sum() / a.sum()
    a_new = np.real(np.poly(q))
    b_new = gain * a_new
    for i, c_i in enumerate(c):  # (1 - z^-1) c_i / (1 - q_i z^-1)
        b_new = b_new + np.real(c_i * np.polymul([1.0, -1.0], np.poly(np.delete(q, i))))
    return b_new, a_new


def _resampled_fir(model: ImpulseResponse, dt: float) -> np.ndarray:
    """h at period dt: the step response, linear between its samples, differenced again."""
    h = np.array(model.h, float)
    if abs(dt / model.dt - 1) < 1e-9:
        return h
    t_end = len(h) * model.dt
    t = np.arange(int(np.ceil(t_end / dt)) + 1) * dt
    step = np.interp(t, np.arange(len(h)) * model.dt, np.cumsum(h))
    return np.diff(step, prepend=0.0)


def _fir_of_response(model: FrequencyResponse, dt: float, axis: str) -> np.ndarray:
    """Causal h from a complex response: inverse transform of an even grid, unit gain at 0 Hz, |H| ~ f^-2 past its end.

    The length is what the frequency spacing can resolve; the last 30 % is tapered by a cosine.
    """
    f, magnitude, phase = (np.array(v, float) for v in (model.frequency, model.magnitude, model.phase))
    if len(phase) != len(f) or not np.isfinite(phase).all() or not np.any(phase):
        raise ModelError(f"axis {axis}: the frequency response has no phase; measure command and response together")
    if len(f) < 8 or not np.all((magnitude > 0) & np.isfinite(magnitude)) or np.any(np.diff(f) <= 0):
        raise ModelError(f"axis {axis}: the frequency response needs 8 or more points in rising order, none zero")
    if not 0.5 < magnitude[0] < 2.0:
        raise ModelError(f"axis {axis}: the response at {f[0]:g} Hz is {magnitude[0]:.3g}; of position it "
                         "is near 1 there, so give it from a lower frequency on, or scale it")  # fmt: skip
    n = 1 << int(np.ceil(np.log2(1 / (np.median(np.diff(f)) * dt))))
    grid = np.fft.rfftfreq(4 * n, dt)
    positive = f > 0
    nodes = np.concatenate(([0.0], f[positive]))
    known = np.concatenate(([0.0], np.log(magnitude) + 1j * np.unwrap(phase)))[-len(nodes) :]
    known[0] = 0.0
    within = np.minimum(grid, f[-1])
    log_H = PchipInterpolator(nodes, known.real)(within) + 1j * PchipInterpolator(nodes, known.imag)(within)
    h = np.fft.irfft(np.exp(log_H) * (f[-1] / np.maximum(grid, f[-1])) ** 2)[:n]
    fade = int(0.3 * n)
    h[n - fade :] *= 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fade + 1) / fade)
    return h / h.sum()


def _checked(b: np.ndarray, a: np.ndarray, dt: float, axis: str) -> Plant:
    """The plant, scaled to unit DC gain. Raises ModelError where it is no plant."""
    if not (len(b) and np.isfinite(b).all() and np.isfinite(a).all()):
        raise ModelError(f"axis {axis}: the model's coefficients are not finite numbers")
    most = _most(dt)
    if len(a) == 1 and len(b) > most:
        raise ModelError(f"axis {axis}: the impulse response has {len(b)} samples, more than {most}; shorten it")
    modulus = float(np.abs(np.roots(a)).max(initial=0.0))
    if modulus >= 1 + MARGINAL:
        raise ModelError(f"axis {axis}: the model is unstable (a pole of modulus {modulus:.6f}); printed coefficients "
                         "are often rounded too far, give more digits or identify again")  # fmt: skip
    if modulus > 1 - MARGINAL:
        raise ModelError(f"axis {axis}: the model has an undamped pole (modulus {modulus:.8f}); give it some damping")
    gain = float(b.sum() / a.sum())
    if not abs(gain - 1) <= DC_TOLERANCE:
        raise ModelError(f"axis {axis}: the model's gain at 0 Hz is {gain:.4g}, not 1; the position at rest must "
                         "follow the command, so scale b or check rounded coefficients")  # fmt: skip
    n = _duration(a, TOLERANCE)
    if n > most:
        raise ModelError(f"axis {axis}: the impulse response is {n} samples long, more than {most}; "
                         "check the damping")  # fmt: skip
    return Plant(b / gain, a, dt)


def _most(dt: float) -> int:
    """Samples that an impulse response may have."""
    return max(MAX_SAMPLES, round(LONGEST_S / dt))


def _duration(a: np.ndarray, tolerance: float) -> int:
    """Samples until the slowest pole's envelope |p|^k has fallen to `tolerance`."""
    modulus = np.abs(np.roots(a)).max(initial=0.0)
    return int(np.ceil(np.log(tolerance) / np.log(modulus))) if modulus > 0 else 1


def _residues(plant: Plant) -> tuple[np.ndarray, np.ndarray]:
    """Poles p and residues r of b/a = sum r_i / (z - p_i) + ..., for simple poles."""
    n = max(len(plant.b), len(plant.a))
    b, a = (np.concatenate((v, np.zeros(n - len(v)))) for v in (plant.b, plant.a))
    p = np.roots(plant.a)
    with np.errstate(divide="ignore", invalid="ignore"):
        return p, np.polyval(b, p) / np.polyval(np.polyder(a), p)


def realised(h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Poles and residues of the smallest system with impulse response h (Ho-Kalman, from the Hankel matrix's SVD)."""
    rows = min(HANKEL, len(h) // 2)
    H = h[1 : 2 * rows]
    if rows < 4:
        return np.zeros(0), np.zeros(0)
    hankel = np.lib.stride_tricks.sliding_window_view(H, rows)
    U, sigma, Vt = svd(hankel)
    n = int(np.sum(sigma > RANK * sigma[0]))
    root = np.sqrt(sigma[:n])
    observed, reached = U[:, :n] * root, root * Vt[:n, 0]
    A = np.linalg.lstsq(observed[:-1], observed[1:], rcond=None)[0]
    p, T = np.linalg.eig(A)
    return p, (observed[0] @ T) * np.linalg.solve(T, reached.astype(complex))
