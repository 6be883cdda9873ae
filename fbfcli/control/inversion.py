"""Inverses of a plant with zeros that cannot be cancelled, one function each (Duan 2015 Table 1, Ramani 2020 Sec. 2.7).

C controller, L = C G overall, E = 1 - L; G = z^-d B_s B_u / A, n = degree of B_u. Every method cancels A and B_s and
differs in what it does for 1 / B_u. Each says in a ModelError where it does not apply.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.control.factored_plant import FactoredPlant
from fbfcli.control.split_filter import ON_CIRCLE, split_filter
from fbfcli.control.two_sided import IDENTITY, TwoSided
from fbfcli.errors import ModelError

TERMS = 5  # n_1 of a truncated series, as in Ramani 2020 Sec. 2.7
AT_ONE = 1e-9  # B_u(1) under this part of its coefficients: G answers no constant
GRID = np.linspace(0, np.pi, 4097)  # rad/sample, where a series' convergence is tried


@dataclass(frozen=True)
class Inverse:
    """One method for one plant.

    C : TwoSided   controller
    L : TwoSided   overall dynamics C G
    """

    C: TwoSided
    L: TwoSided


def npz_ignore(G: FactoredPlant) -> Inverse:
    """C = z^d A / (B_s B_u(1)), L = B_u / B_u(1): uncancellable zeros stay. Not for a zero at 1."""
    at_one = _at_one(G, "npz_ignore")
    return Inverse(_with_rest(G, TwoSided(np.array([1 / at_one]), 0)), TwoSided(G.B_u / at_one, 0))


def zpetc(G: FactoredPlant) -> Inverse:
    """C = z^d A B_u(z) / (B_s B_u(1)^2), L = B_u(z^-1) B_u(z) / B_u(1)^2: no phase error. Not for a zero at 1."""
    mirrored = TwoSided(G.B_u[::-1] / _at_one(G, "zpetc") ** 2, len(G.B_u) - 1)
    return Inverse(_with_rest(G, mirrored), mirrored.then(TwoSided(G.B_u, 0)))


def zmetc(G: FactoredPlant) -> Inverse:
    """C = z^d A / (B_s B_u(z)), L = B_u(z^-1) / B_u(z): no magnitude error. Not for zeros on the unit circle.

    A zero inside the circle that is not cancelled (poorly damped) has its mirror image outside: run backward in time.
    """
    _off_circle(G, "zmetc")
    n = len(G.B_u) - 1
    over = split_filter(np.ones(1), G.B_u[::-1], ahead=-n).impulse_response()
    return Inverse(_with_rest(G, over), over.then(TwoSided(G.B_u, 0)))


def extended_zpetc(G: FactoredPlant, terms: int = TERMS) -> Inverse:
    """ZPETC times 1 + E + ... + E^terms, E its error: L = 1 - E^(terms + 1) (Torfs 1992).

    Not where |E| > 1 at some frequency: more terms make it worse there. Of one real zero a: 4 a > (1 - a)^2.
    """
    _at_one(G, "ebzpetc")
    plain = zpetc(G)
    E = plain.L.error()
    largest = float(np.abs(E.response(GRID)).max())
    if largest > 1 + AT_ONE:
        raise ModelError(f"ebzpetc: its series does not converge on this plant (|E| reaches {largest:.3g} > 1), as for "
                         "zeros in the right half plane near 1; take ts or stable_inversion")  # fmt: skip
    series = power = IDENTITY
    for _ in range(terms):
        power = power.then(E)
        series = series.plus(power)
    return Inverse(plain.C.then(series), plain.L.then(series))


def truncated_series(G: FactoredPlant, terms: int = TERMS) -> Inverse:
    """1 / B_u by n_1 = `terms` terms of its power series, zeros outside the circle in z and inside in z^-1.

    Of one zero a: L = 1 - a^-n_1 z^n_1 for |a| > 1, 1 - a^n_1 z^-n_1 for |a| < 1, Ramani 2020 Eq. 2.29. Not for zeros
    on the unit circle.
    """
    _off_circle(G, "ts")
    outside = np.abs(G.zeros_u) > 1
    forward, backward = (np.atleast_1d(np.real(np.poly(z))) for z in (G.zeros_u[~outside], G.zeros_u[outside]))
    later = _series(forward, terms)
    sooner = _series(backward[::-1] / backward[-1], terms) / backward[-1]  # in z: 1 / B = z^n / (b_n + ... + z^n)
    n = len(backward) - 1
    series = TwoSided(later, 0).then(TwoSided(sooner[::-1], terms - 1 + n))
    return Inverse(_with_rest(G, series), series.then(TwoSided(G.B_u, 0)))


def stable_inversion(G: FactoredPlant, preview: int | None = None) -> Inverse:
    """1 / G, its unstable part backward in time over at most `preview` samples (Zou 1999; None: until it has died out).

    Not for zeros on the unit circle.
    """
    _off_circle(G, "stable_inversion")
    C = split_filter(G.A, np.convolve(G.B_s, G.B_u), ahead=G.d).impulse_response()
    if preview is not None and C.ahead > preview:
        C = TwoSided(C.c[C.ahead - preview :], preview)
    h = split_filter(np.convolve(G.B_s, G.B_u), G.A, ahead=-G.d).impulse_response()
    return Inverse(C, C.then(h))


def _with_rest(G: FactoredPlant, over: TwoSided) -> TwoSided:
    """z^d A / B_s times what stands for 1 / B_u."""
    return split_filter(G.A, G.B_s, ahead=G.d).impulse_response().then(over)


def _series(b: np.ndarray, terms: int) -> np.ndarray:
    """The first coefficients of 1 / (1 + b_1 x + b_2 x^2 + ...)."""
    g = np.zeros(terms)
    g[0] = 1.0
    for k in range(1, terms):
        reach = min(k, len(b) - 1)
        g[k] = -b[1 : reach + 1] @ g[k - reach : k][::-1]
    return g


def _at_one(G: FactoredPlant, name: str) -> float:
    """B_u(1). Raises ModelError where it is zero."""
    value = float(G.B_u.sum())
    if abs(value) <= AT_ONE * np.abs(G.B_u).sum():
        raise ModelError(f"{name} does not apply: the plant has a zero at 1, so it holds no position")
    return value


def _off_circle(G: FactoredPlant, name: str) -> None:
    """Raise ModelError where a zero is on the unit circle."""
    for z in G.zeros_u[np.abs(np.abs(G.zeros_u) - 1) < ON_CIRCLE]:
        where = f"{z.real:.4g}" if abs(z.imag) < AT_ONE else f"{z.real:.4g} +- {abs(z.imag):.4g}j"
        raise ModelError(f"{name} does not apply: the plant has a zero on the unit circle, at {where}; take zpetc, "
                         "npz_ignore or lpfbs")  # fmt: skip
