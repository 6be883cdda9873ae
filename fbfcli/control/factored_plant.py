"""A plant's zeros, sorted: those that an inverse may cancel, and those that it must not, Duan 2015 Eq. 1.

G(z) = z^-d B_s(z^-1) B_u(z^-1) / A(z^-1)
A cancelled zero is a pole of the command. It is cancelled if, as such, it is stable and well damped: its damping ratio
-Re(ln z) / |ln z| is ZETA_MIN or more (a ringing that falls to a third within 8 periods) and its modulus is at most
RADIUS_MAX (a memory of 200 samples at most). zeta_min > 1 cancels none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.errors import ModelError

ZETA_MIN = 0.02
RADIUS_MAX = 0.995
DELAYED = 1e-9  # leading coefficients under this part of the largest are a delay, not a zero at a million
MAX_ZEROS = 40  # roots of longer polynomials are not to be trusted


@dataclass(frozen=True)
class FactoredPlant:
    """G = z^-d B_s B_u / A, coefficients of z^0, z^-1, ...

    d       : int                delay [samples]
    A       : ndarray            A[0] = 1
    B_s     : ndarray            cancellable zeros and the gain
    B_u     : ndarray            the others, B_u[0] = 1
    zeros_u : complex ndarray    roots of B_u in z
    """

    d: int
    A: np.ndarray
    B_s: np.ndarray
    B_u: np.ndarray
    zeros_u: np.ndarray


def factored(b: np.ndarray, a: np.ndarray, zeta_min: float = ZETA_MIN) -> FactoredPlant:
    """The plant b(z^-1) / a(z^-1) by its zeros. Raises ModelError where it has too many to be told apart."""
    b, a = np.asarray(b, float), np.asarray(a, float)
    d = int(np.argmax(np.abs(b) > DELAYED * np.abs(b).max()))
    b = np.trim_zeros(b[d:], "b")
    if len(b) - 1 > MAX_ZEROS:
        raise ModelError(f"inverse methods need the model's zeros, and an impulse response of {len(b)} samples does "
                         "not give them: describe the axis by modes or a transfer function, or take lpfbs")  # fmt: skip
    z = np.roots(b).astype(complex)
    good = cancellable(z, zeta_min)
    B_s, B_u = np.real(np.poly(z[good])), np.real(np.poly(z[~good]))
    return FactoredPlant(d, a / a[0], np.atleast_1d(B_s) * b[0] / a[0], np.atleast_1d(B_u), z[~good])


def cancellable(z: np.ndarray, zeta_min: float = ZETA_MIN) -> np.ndarray:
    """Which zeros, shape (n,), an inverse may cancel."""
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.log(z.astype(complex))
        damping = np.where(z == 0, 1.0, -s.real / np.abs(s))
    return np.asarray((np.abs(z) <= RADIUS_MAX) & (damping >= zeta_min))
