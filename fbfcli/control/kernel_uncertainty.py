"""Dynamic uncertainty by kernels: magnitude and phase spread about measured responses, Ramani 2020b Sec. III-C.

r_i, theta_i magnitude and phase of the i-th measured response, i = 1..l, at each of n frequencies; sigma_r, sigma_theta
widths of the normal kernels K (the same for all l); f(r, theta) = f_1(r) f_2(theta) their density within the bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import erf, ndtri

MAD_TO_SIGMA = 0.6744897501960817  # median absolute deviation of a normal distribution with sigma 1
KNOWN = 1e-9  # of the magnitude, or radians: kernels and bounds are no narrower, though all responses may agree


@dataclass(frozen=True)
class KernelUncertainty:
    """Measured responses and kernels about them.

    r, theta             : ndarrays, shape (l, n)   magnitudes, continuous phases [rad]
    sigma_r, sigma_theta : ndarrays, shape (n,)     widths
    """

    r: np.ndarray
    theta: np.ndarray
    sigma_r: np.ndarray
    sigma_theta: np.ndarray

    @property
    def bounds(self) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Least and largest magnitude and phase measured, Ramani 2020b Eq. 17; never the same."""
        known = KNOWN * self.r.max(axis=0)
        r = self.r.min(axis=0) - known, self.r.max(axis=0) + known
        return r, (self.theta.min(axis=0) - KNOWN, self.theta.max(axis=0) + KNOWN)

    def robust_filter(self) -> np.ndarray:
        """G_r, complex, shape (n,), Ramani 2020b Eq. 19: sum alpha_r sum alpha_theta / (sum beta_r sum beta_theta).

        alpha_r = int K r^3 dr, beta_r = int K r^2 dr, alpha_theta = int K dtheta and beta_theta =
        int K e^(-j theta) dtheta over the bounds: Eq. 11 with dDelta = r dr dtheta, an area of the complex plane.
        """
        (r_0, r_1), (theta_0, theta_1) = self.bounds
        lower, upper = (r_0 - self.r) / self.sigma_r, (r_1 - self.r) / self.sigma_r
        m = _normal_moments(lower, upper)
        mu, s = self.r, self.sigma_r  # r = mu + s x
        alpha_r = mu**3 * m[0] + 3 * mu**2 * s * m[1] + 3 * mu * s**2 * m[2] + s**3 * m[3]
        beta_r = mu**2 * m[0] + 2 * mu * s * m[1] + s**2 * m[2]
        lower, upper = (theta_0 - self.theta) / self.sigma_theta, (theta_1 - self.theta) / self.sigma_theta
        alpha_theta = _normal_moments(lower, upper)[0]
        j_sigma = 1j * self.sigma_theta
        turned = erf((upper + j_sigma) / np.sqrt(2)) - erf((lower + j_sigma) / np.sqrt(2))
        beta_theta = 0.5 * np.exp(-1j * self.theta - self.sigma_theta**2 / 2) * turned
        return np.asarray(alpha_r.sum(axis=0) * alpha_theta.sum(axis=0) / (beta_r.sum(axis=0) * beta_theta.sum(axis=0)))

    def realisations(self, count: int, seed: int) -> np.ndarray:
        """Plants drawn from f(r, theta) within the bounds, complex, shape (count, n).

        A plant is as far up its distribution at one frequency as at every other: two uniform numbers draw it, one for
        magnitude and one for phase, so that it stays a smooth response.
        """
        rng = np.random.default_rng(seed)
        which = rng.integers(len(self.r), size=(2, count))
        place = rng.random((2, count))
        (r_0, r_1), (theta_0, theta_1) = self.bounds
        r = _drawn(self.r[which[0]], self.sigma_r, r_0, r_1, place[0])
        theta = _drawn(self.theta[which[1]], self.sigma_theta, theta_0, theta_1, place[1])
        return np.asarray(r * np.exp(1j * theta))


def kernel_uncertainty(G: np.ndarray) -> KernelUncertainty:
    """Of measured responses G, complex, shape (l, n), frequencies rising: widths that are best for normal densities.

    sigma = (4 / (3 l))^(1/5) s, s the median absolute deviation in units of sigma (Bowman & Azzalini 1997).
    """
    r, theta = np.abs(G), np.unwrap(np.angle(G), axis=1)
    middle = np.angle(np.exp(1j * theta[:, :1]).sum())
    theta -= 2 * np.pi * np.round((theta[:, :1] - middle) / (2 * np.pi))  # one branch for all of them
    narrow = (4 / (3 * len(G))) ** 0.2
    sigma_r, sigma_theta = narrow * _deviation(r), narrow * _deviation(theta)
    return KernelUncertainty(r, theta, np.maximum(sigma_r, KNOWN * r.max(axis=0)), np.maximum(sigma_theta, KNOWN))


def _deviation(x: np.ndarray) -> np.ndarray:
    """Robust standard deviation of each column; the range where more than half of it is the same."""
    s = np.median(np.abs(x - np.median(x, axis=0)), axis=0) / MAD_TO_SIGMA
    return np.asarray(np.where(s > 0, s, np.ptp(x, axis=0)))


def _normal_moments(lower: np.ndarray, upper: np.ndarray) -> list[np.ndarray]:
    """int x^k phi(x) dx from lower to upper, k = 0..3, phi the standard normal density.

    x^k phi integrates to (k - 1) times the integral of x^(k-2) phi, less x^(k-1) phi at the ends.
    """
    phi = [np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi) for x in (lower, upper)]
    zeroth = 0.5 * (erf(upper / np.sqrt(2)) - erf(lower / np.sqrt(2)))
    first = phi[0] - phi[1]
    second = zeroth + lower * phi[0] - upper * phi[1]
    third = 2 * first + lower**2 * phi[0] - upper**2 * phi[1]
    return [zeroth, first, second, third]


def _drawn(mean: np.ndarray, sigma: np.ndarray, low: np.ndarray, high: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Normal numbers between low and high, at the given part of what lies between them; mean (count, n)."""
    below, above = (0.5 * (1 + erf((end - mean) / (sigma * np.sqrt(2)))) for end in (low, high))
    x = mean + sigma * ndtri(below + place[:, None] * (above - below))
    return np.asarray(np.clip(x, low, high))
