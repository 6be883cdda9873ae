"""Impulse responses cut short for speed, without moving what they do to slow motion.

A response that ends after n samples is tapered by a cosine, and then corrected so that
    sum_k k^q h[k],  q = 0, 1, 2
are what they were: the answer to rest, to constant speed and to constant acceleration. With the gain at rest restored
alone, the command would be off by a part of the speed.
"""

from __future__ import annotations

import numpy as np

AUDIBLE = 0.05  # of the largest sample: the response is cut where it stays below
TAPER = 0.3  # of the response's length
MOMENTS = 3


def truncated(h: np.ndarray) -> np.ndarray:
    """The response h, shape (n,), until it stays below AUDIBLE; its first moments kept."""
    n = int(np.flatnonzero(np.abs(h) >= AUDIBLE * np.abs(h).max())[-1]) + 1
    fade = int(TAPER * n)
    if n == len(h) or fade < MOMENTS:
        return h
    window = np.ones(n)
    window[n - fade :] = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, fade + 1) / (fade + 1))
    g = h[:n] * window
    powers = np.vander(np.arange(len(h)) / n - 1.0, MOMENTS, increasing=True)
    missing = powers.T @ h - powers[:n].T @ g
    # put back where it was taken: under the taper. Spread over the response, it would cost a tenth of the accuracy
    shape = powers[:n] * (1.0 - window)[:, None]
    return np.asarray(g + shape @ np.linalg.solve(powers[:n].T @ shape, missing))
