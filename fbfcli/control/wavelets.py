"""Orthogonal wavelets on a finite trajectory of any length: an orthonormal basis from coarse to fine.

h, g scaling and wavelet filter, Phi (M + 1, n + 1) the coarsest n + 1 functions. The filters are PyWavelets'; its
transforms pad odd lengths, which would cost the basis its orthonormality, so the cascade is written out here.
"""

from __future__ import annotations

import numpy as np

from fbfcli.errors import ControlError

DEFAULT = "db4"


def filters(name: str) -> tuple[np.ndarray, np.ndarray]:
    """h and g of an orthogonal wavelet by its usual name (db4, sym8, coif2), shape (taps,). Raises ControlError."""
    import pywt

    if name not in pywt.wavelist(kind="discrete") or not pywt.Wavelet(name).orthogonal:
        raise ControlError(f"no orthogonal wavelet {name!r}: take one of db1 to db38, sym2 to sym20, coif1 to coif17")
    found = pywt.Wavelet(name)
    return np.array(found.rec_lo), np.array(found.rec_hi)


def wavelets(M: int, n: int, name: str = DEFAULT) -> np.ndarray:
    """The coarsest n + 1 functions on samples 0..M, orthonormal columns, shape (M + 1, n + 1).

    Periodised (Mallat's cascade, read as a matrix); where a level has an odd number of functions its last one goes on
    to the next level as it is, which keeps any length orthonormal. Levels end where the filter would overlap itself.
    """
    if not 0 <= n <= M:
        raise ControlError(f"{n + 1} functions on {M + 1} samples: take 1 to {M + 1}")
    h, g = filters(name)
    width = len(h)
    coarse, details = np.eye(M + 1), []
    while coarse.shape[1] >= 2 * width:
        count = coarse.shape[1] // 2
        taps = (2 * np.arange(count)[:, None] + np.arange(width)) % (2 * count)
        mix = np.zeros((2, coarse.shape[1], count))
        for filter_, into in zip((h, g), mix, strict=True):
            np.add.at(into, (taps, np.arange(count)[:, None]), filter_)
        details.append(coarse @ mix[1])
        coarse = np.hstack((coarse @ mix[0], coarse[:, 2 * count :]))
    return np.hstack([coarse, *details[::-1]])[:, : n + 1]
