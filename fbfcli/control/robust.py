"""The robust filter: what basis functions are filtered by when the plant is one of a family (Ramani 2020b, Sec. III).

G (J, n) responses of the family on a frequency grid, f (J,) their probabilities, G_r (n,) the robust filter
"""

from __future__ import annotations

import numpy as np


def robust_filter(G: np.ndarray, f: np.ndarray) -> np.ndarray:
    """G_r = E[G G*] / E[G*], the inverse of the controller of least expected error, Ramani 2020b Eq. 11.

    G : complex ndarray, shape (J, n)   frequency responses of the family
    f : ndarray, shape (J,)             probability of each, sum 1

    Where the family's mean is zero there is no such controller and G_r is infinite.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((f @ np.abs(G) ** 2) / (f @ G.conj()))
