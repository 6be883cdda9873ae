"""Right-hand sides of uniform splines: how much of the desired path each filtered spline meets."""

from __future__ import annotations

import numpy as np

BLOCK = 256  # splines whose sums are made at once: their products stay in the cache


def projected(psi: np.ndarray, Y: np.ndarray, n: int) -> np.ndarray:
    """r_i = sum_s psi[s] . Y[i + s] for i < n, shape (n,); intervals past the last row of Y count as zero.

    psi : ndarray, shape (S, L)   filtered spline, cut at the knots
    Y   : ndarray, shape (N, L)   samples, cut at the knots
    """
    S = len(psi)
    r = np.empty(n)
    for i in range(0, n, BLOCK):
        count = min(BLOCK, n - i)
        part = Y[i : i + count - 1 + S]
        s = min(S, len(part))
        width = count - 1 + s
        # C[q, j] = psi's piece q on interval j; r_i sums C[q, i + q]: rows one longer put that diagonal in columns
        C = np.zeros(s * (width + 1))
        if len(part) < width:
            part = np.concatenate((part, np.zeros((width - len(part), Y.shape[1]))))
        np.matmul(psi[:s], part[:width].T, out=C[: s * width].reshape(s, width))
        r[i : i + count] = C.reshape(s, width + 1)[:, :count].sum(axis=0)
    return r
