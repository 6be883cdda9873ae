"""Daubechies wavelets on a finite trajectory of any length: an orthonormal basis from coarse to fine.

h scaling filter of 2 N taps, N vanishing moments, Phi (M + 1, n + 1) the coarsest n + 1 functions. scipy has no wavelet
filters any more, and a library for one filter and one loop would not pay: both are Daubechies 1988, Sec. 4.
"""

from __future__ import annotations

from math import comb

import numpy as np

from fbfcli.errors import ControlError

MOST_MOMENTS = 10  # beyond it the roots of the polynomial lose the digits that make the filter orthonormal


def scaling_filter(N: int) -> np.ndarray:
    """h of N vanishing moments, shape (2 N,), sum sqrt(2), extremal phase.

    |H|^2 = (cos^2 w/2)^N P(sin^2 w/2), P(y) = sum_k binom(N - 1 + k, k) y^k (Daubechies 1988, Eq. 4.16); each root y of
    P is a pair of roots z + 1/z = 2 - 4 y, of which the one inside the unit circle is taken.
    """
    if not 1 <= N <= MOST_MOMENTS:
        raise ControlError(f"wavelets with {N} vanishing moments: take 1 to {MOST_MOMENTS}")
    y = np.roots([comb(N - 1 + k, k) for k in range(N - 1, -1, -1)])
    half = 1 - 2 * y + 0j
    z = half + np.sqrt(half**2 - 1)
    z = np.where(np.abs(z) < 1, z, 1 / z)
    h = np.real(np.poly(np.concatenate((-np.ones(N), z))))
    return h * np.sqrt(2) / h.sum()


def wavelets(M: int, n: int, N: int = 4) -> np.ndarray:
    """The coarsest n + 1 functions on samples 0..M, orthonormal columns, shape (M + 1, n + 1).

    Periodised (Mallat's cascade, read as a matrix); where a level has an odd number of functions its last one goes on
    to the next level as it is, which keeps any length orthonormal. Levels end where the filter would overlap itself.
    """
    if not 0 <= n <= M:
        raise ControlError(f"{n + 1} functions on {M + 1} samples: take 1 to {M + 1}")
    h = scaling_filter(N)
    g = h[::-1] * (-1.0) ** np.arange(2 * N)  # the wavelet's filter mirrors the scaling filter
    coarse, details = np.eye(M + 1), []
    while coarse.shape[1] >= 4 * N:
        count = coarse.shape[1] // 2
        taps = (2 * np.arange(count)[:, None] + np.arange(2 * N)) % (2 * count)
        mix = np.zeros((2, coarse.shape[1], count))
        for filter_, into in zip((h, g), mix, strict=True):
            np.add.at(into, (taps, np.arange(count)[:, None]), filter_)
        details.append(coarse @ mix[1])
        coarse = np.hstack((coarse @ mix[0], coarse[:, 2 * count :]))
    return np.hstack([coarse, *details[::-1]])[:, : n + 1]
