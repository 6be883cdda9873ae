"""How much the path matters, sample by sample: while printing fully, on the way between less."""

from __future__ import annotations

import numpy as np


def importance(extruding: np.ndarray, travel: float, ramp: int) -> np.ndarray:
    """Weight of each sample, shape (n,): 1 where it prints, `travel` from `ramp` samples away on, linear between.

    extruding : ndarray of bool, shape (n,)
    """
    k = np.arange(len(extruding))
    after = k - np.maximum.accumulate(np.where(extruding, k, -ramp))
    before = np.minimum.accumulate(np.where(extruding, k, len(k) + ramp)[::-1])[::-1] - k
    return 1.0 - (1.0 - travel) * np.minimum(np.minimum(after, before) / ramp, 1.0)
