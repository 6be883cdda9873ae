"""Filtering with unstable poles: stable dynamics forward in time, unstable ones backward, Ramani 2020b Sec. III-B.

H(z) = z^ahead b(z^-1) / a(z^-1) = z^shift (Q(z) + R_s(z) / a_s(z) + R_u(z) / a_u(z)), polynomials in z:
a_s has the poles inside the unit circle, a_u those outside, and
    b = Q a_s a_u + R_s a_u + R_u a_s        deg R_s < deg a_s, deg R_u < deg a_u
Poles on the unit circle belong to neither: they are moved off it, as in Devasia 1999 (Ramani 2020b's [33]).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve, toeplitz
from scipy.signal import lfilter

from fbfcli.control.two_sided import TwoSided
from fbfcli.errors import ModelError

ON_CIRCLE = 1e-6  # |p| nearer than this to one is on the circle
PERTURBED = 0.999  # such a pole p goes to p / PERTURBED: outside, as Ramani 2020b App. A takes 0.999 for a_nom = 1
MAX_SAMPLES = 200_000  # of an impulse response


@dataclass(frozen=True)
class SplitFilter:
    """A rational filter by its stable and its unstable part; polynomials in z, highest power first.

    shift    : int       of the whole, z^shift
    Q        : ndarray   polynomial part
    R_s, a_s : ndarrays  stable part, run forward
    R_u, a_u : ndarrays  unstable part, run backward
    """

    shift: int
    Q: np.ndarray
    R_s: np.ndarray
    a_s: np.ndarray
    R_u: np.ndarray
    a_u: np.ndarray

    def filtered(self, x: np.ndarray) -> np.ndarray:
        """Output for samples x, shape (n,) or (n, m): at rest outside, as many out as in."""
        room = abs(self.shift) + len(self.Q)
        rest = np.zeros((room, *x.shape[1:]))
        v = np.concatenate((rest, x, rest))
        n_q = len(self.Q) - 1
        straight = np.roll(lfilter(self.Q, [1.0], v, axis=0), -n_q, axis=0)  # wraps zeros of `rest` only
        y = straight + _forward(self.R_s, self.a_s, v) + _backward(self.R_u, self.a_u, v)
        return y[room + self.shift : room + self.shift + len(x)]

    def impulse_response(self, tolerance: float = 1e-12) -> TwoSided:
        """Both sides until each part's slowest envelope is under `tolerance`. Raises ModelError where that is far."""
        after = _duration(np.abs(np.roots(self.a_s)), tolerance) + len(self.Q) + 1
        before = _duration(1 / np.abs(np.roots(self.a_u)), tolerance) + len(self.Q) + 1
        x = np.zeros(before + 1 + after)
        x[before] = 1.0
        return TwoSided(SplitFilter(0, self.Q, self.R_s, self.a_s, self.R_u, self.a_u).filtered(x), before + self.shift)


def split_filter(b: np.ndarray, a: np.ndarray, ahead: int = 0) -> SplitFilter:
    """Of z^ahead b(z^-1) / a(z^-1), coefficients of z^0, z^-1, ..."""
    a = np.trim_zeros(np.atleast_1d(np.asarray(a, float)), "b")
    b = np.trim_zeros(np.atleast_1d(np.asarray(b, float)), "b")
    p = _off_circle(np.roots(a))
    a_s, a_u = np.real(np.poly(p[np.abs(p) < 1])), np.real(np.poly(p[np.abs(p) > 1]))
    Q, R = np.polydiv(b / np.trim_zeros(a, "f")[0], np.convolve(a_s, a_u))
    R_s, R_u = _shared_out(R, np.atleast_1d(a_s), np.atleast_1d(a_u))
    shift = ahead - (len(b) - 1) + (len(a) - 1)
    return SplitFilter(shift, Q, R_s, np.atleast_1d(a_s), R_u, np.atleast_1d(a_u))


def _off_circle(p: np.ndarray) -> np.ndarray:
    """Poles on the unit circle moved to radius 1 / PERTURBED."""
    radius = np.abs(p)
    return np.where(np.abs(radius - 1) < ON_CIRCLE, p / (PERTURBED * np.where(radius > 0, radius, 1.0)), p)


def _shared_out(R: np.ndarray, a_s: np.ndarray, a_u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """R_s, R_u with R = R_s a_u + R_u a_s (Sylvester's equations)."""
    n_s, n_u = len(a_s) - 1, len(a_u) - 1
    n = n_s + n_u
    if n == 0:
        return np.zeros(1), np.zeros(1)
    columns = np.hstack([_shifted(a_u, n, n_s), _shifted(a_s, n, n_u)])
    right = np.concatenate((np.zeros(n), np.atleast_1d(R)))[-n:]
    both = solve(columns, right)
    return np.append(both[:n_s], [] if n_s else [0.0]), np.append(both[n_s:], [] if n_u else [0.0])


def _shifted(a: np.ndarray, rows: int, count: int) -> np.ndarray:
    """Columns of products z^(count - 1) a, ..., a: multiplication by a as a matrix."""
    return toeplitz(np.concatenate((a, np.zeros(rows - len(a)))), np.zeros(count)) if count else np.zeros((rows, 0))


def _forward(R: np.ndarray, a: np.ndarray, x: np.ndarray) -> np.ndarray:
    """R(z) / a(z) x, poles inside: strictly causal, deg R < deg a."""
    return lfilter(np.concatenate((np.zeros(len(a) - len(R)), R)), a, x, axis=0)


def _backward(R: np.ndarray, a: np.ndarray, x: np.ndarray) -> np.ndarray:
    """R(z) / a(z) x, poles outside: with time reversed z is a delay and the polynomials' lowest powers come first."""
    return lfilter(R[::-1] / a[-1], a[::-1] / a[-1], x[::-1], axis=0)[::-1]


def _duration(modulus: np.ndarray, tolerance: float) -> int:
    """Samples until the slowest of the given decays per sample has fallen to `tolerance`."""
    slowest = modulus.max(initial=0.0)
    n = int(np.ceil(np.log(tolerance) / np.log(slowest))) if slowest > 0 else 0
    if n > MAX_SAMPLES:
        raise ModelError(f"a pole of modulus {slowest:.8f} rings for {n} samples, more than {MAX_SAMPLES}")
    return n
