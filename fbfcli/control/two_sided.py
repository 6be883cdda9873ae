"""A filter that hears the future as well as the past, by its impulse response: y[k] = sum_j c[j] x[k + ahead - j]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import convolve


@dataclass(frozen=True)
class TwoSided:
    """z^ahead (c_0 + c_1 z^-1 + ...).

    c     : ndarray, shape (n,)   response at times -ahead, 1 - ahead, ...
    ahead : int                   samples of the future it hears; negative for a delay
    """

    c: np.ndarray
    ahead: int

    def then(self, other: TwoSided) -> TwoSided:
        """One filter after the other."""
        return TwoSided(convolve(self.c, other.c), self.ahead + other.ahead)

    def plus(self, other: TwoSided, scale: float = 1.0) -> TwoSided:
        """This filter and `scale` times the other, side by side."""
        ahead = max(self.ahead, other.ahead)
        n = max(ahead - self.ahead + len(self.c), ahead - other.ahead + len(other.c))
        c = np.zeros(n)
        for part, factor in ((self, 1.0), (other, scale)):
            c[ahead - part.ahead : ahead - part.ahead + len(part.c)] += factor * part.c
        return TwoSided(c, ahead)

    def error(self) -> TwoSided:
        """1 minus it: E_ff of overall dynamics L, Ramani 2020 Sec. 2.2."""
        return IDENTITY.plus(self, -1.0)

    def cut(self, tolerance: float) -> TwoSided:
        """Without the ends whose absolute values sum to less than `tolerance`, each."""
        size = np.abs(self.c)
        first = int(np.argmax(np.cumsum(size) >= tolerance))
        last = len(size) - int(np.argmax(np.cumsum(size[::-1]) >= tolerance))
        return TwoSided(self.c[first:last], self.ahead - first)

    def response(self, omega: np.ndarray) -> np.ndarray:
        """Complex frequency response at omega [rad/sample]."""
        z = np.exp(-1j * np.asarray(omega))
        return np.polyval(self.c[::-1], z) * z**-self.ahead

    def filtered(self, x: np.ndarray) -> np.ndarray:
        """Output for samples x, shape (n,) or (n, m): zero outside, as many out as in."""
        c = self.c.reshape(-1, *[1] * (x.ndim - 1))
        before, after = max(0, -self.ahead), max(0, self.ahead)
        padded = np.concatenate((np.zeros((before, *x.shape[1:])), x, np.zeros((after, *x.shape[1:]))))
        return convolve(padded, c)[after : after + len(x)]

    def frobenius(self, samples: int) -> float:
        """||T||_F / sqrt(samples) of its lifted (Toeplitz) matrix over `samples` samples, Ramani 2020 Eq. 2.18."""
        lag = np.abs(np.arange(len(self.c)) - self.ahead)
        return float(np.sqrt(np.square(self.c) @ np.maximum(0.0, 1 - lag / samples)))


IDENTITY = TwoSided(np.ones(1), 0)
