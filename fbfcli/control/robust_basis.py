"""Basis functions filtered by the robust filter of a family of plants, Ramani 2020b Sec. III.

G_r = E[G G*] / E[G*] has poles on both sides of the unit circle: of its two stable answers to an impulse, the one that
begins before it is the one to filter with (Sec. III-B: the unstable part is run backwards in time).
"""

from __future__ import annotations

import numpy as np

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.robust import robust_filter
from fbfcli.errors import ModelError

FADED = 1e-5  # of the largest sample: what is left out at both ends; 1e-4 would lead slow motion by a part of its delay
PADDED = 4  # times the family's longest response: what G_r's answer needs on the circle of the transform
LONGEST = 1 << 17  # samples of that circle at most


def robust_response(axis: AxisModel) -> tuple[np.ndarray, int]:
    """Impulse response of G_r, sum 1, and how many of its samples come before the impulse.

    Raises ModelError where the members of the family cancel each other: then nothing is expected of any command.
    """
    if len(axis.family) == 1:
        return axis.family[0] / axis.family[0].sum(), 0
    n = 1 << int(np.ceil(np.log2(PADDED * max(len(h) for h in axis.family))))
    while True:
        G_r = robust_filter(np.array([np.fft.rfft(h, n) for h in axis.family]), axis.weights)
        if not np.isfinite(G_r).all():
            raise ModelError("the family's members cancel each other at some frequency: narrow its range")
        h = np.roll(np.fft.irfft(G_r, n), n // 2)
        kept = np.flatnonzero(np.abs(h) > FADED * np.abs(h).max())
        if kept[0] > n // 8 and kept[-1] < n - n // 8:
            break
        n *= 2
        if n > LONGEST:
            raise ModelError("the robust filter of this family rings on without end: narrow its range")
    h = h[kept[0] : kept[-1] + 1]
    return h / h.sum(), n // 2 - int(kept[0])
