"""The inverses of `inversion` on long trajectories: as filters of finite length, centred in time.

u = F C y_d, C an inverse's response cut where it has died out and F a B-spline of degree 3 with knots every L samples
as a smoothing filter of zero phase. C alone answers a step of acceleration with a step of position, which no machine
takes; with L = 0 there is no F. F costs an error of (m + 1) / 24 (L dt)^2 y_d'', so L is short. 8 motions of 1.5 s
planned at 5000 mm/s^2, dt = 1 ms, tracking error RMS [um] / largest |u''| over 5000 mm/s^2:
             npz_ignore  zpetc     zmetc    ebzpetc   ts       stable_inversion  lpfbs     none
TAZ 6, L 4   117/7       53/23     217/6    no        154/5    8.4/4.5           4.5/2.3   488/1
TAZ 6, L 0   112/367     114/11081 216/21   no        153/57   1.6/17
35 Hz, L 4   57/2.3      7.9/2.3   113/2.3  7.5/2.4   7.5/2.4  7.5/2.4           1.2/1.8   112/1
35 Hz, L 0   57/65       0.5/41    114/100  0.1/86    0.3/90   0.1/90
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import ceil

import numpy as np

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.basis import uniform_basis
from fbfcli.control.compensator import AT_REST, Compensator
from fbfcli.control.factored_plant import ZETA_MIN, FactoredPlant, factored
from fbfcli.control.fir_compensator import FirCompensator
from fbfcli.control.inversion import (
    TERMS,
    Inverse,
    extended_zpetc,
    npz_ignore,
    stable_inversion,
    truncated_series,
    zmetc,
    zpetc,
)
from fbfcli.control.two_sided import IDENTITY, TwoSided

INVERSION_METHODS = ("npz_ignore", "zpetc", "zmetc", "ebzpetc", "ts", "stable_inversion")
INVERSION_OPTIONS = ("terms", "preview", "zero_damping", "smooth")
SMOOTH_S = 0.004  # between knots of F
DEGREE = 3  # of F: the command's acceleration is continuous though the desired one jumps
WIDER = 1.4  # knots of F, each time the command must be gentler
STEPS = 3
PREVIEW_S = 0.25  # of stable inversion
DIED_OUT = 3e-3  # of a response: what is cut off moves the command by less than this part of the motion it would hear


def inverse(name: str, axes: Sequence[AxisModel], dt: float, options: Mapping[str, float] | None = None) -> Compensator:
    """The compensator called `name`, one of INVERSION_METHODS, for axes of period dt [s].

    options : terms (of ts, ebzpetc), preview [samples] (of stable_inversion), zero_damping (zeros damped less are not
              cancelled), smooth (samples between knots of the smoothing filter, 0 for none)

    Raises ModelError where the method does not apply to an axis, ValueError for an unknown name or option.
    """
    given = dict(options or {})
    if name not in INVERSION_METHODS or not given.keys() <= set(INVERSION_OPTIONS):
        raise ValueError(f"unknown method or option in {name!r}, {sorted(given)}: methods {INVERSION_METHODS}, "
                         f"options {INVERSION_OPTIONS}")  # fmt: skip
    terms, preview = int(given.get("terms", TERMS)), int(given.get("preview", ceil(PREVIEW_S / dt)))
    L = given.get("smooth", SMOOTH_S / dt)
    if terms < 1 or preview < 1 or L < 0:
        raise ValueError("terms and preview must be at least 1, smooth not negative")
    plants = [factored(axis.b, axis.a, given.get("zero_damping", ZETA_MIN)) for axis in axes]
    controllers = [_inverse_of(name, plant, terms, preview).C for plant in plants]
    widths = [round(L * WIDER**step) for step in range(STEPS + 1)] if L > 0 else [0]
    return _levels(name, [_smoothed(controllers, width) for width in widths])


def _inverse_of(name: str, G: FactoredPlant, terms: int, preview: int) -> Inverse:
    if name == "ebzpetc":
        return extended_zpetc(G, terms)
    if name == "ts":
        return truncated_series(G, terms)
    if name == "stable_inversion":
        return stable_inversion(G, preview)
    return {"npz_ignore": npz_ignore, "zpetc": zpetc, "zmetc": zmetc}[name](G)


def _smoothed(controllers: Sequence[TwoSided], L: int) -> list[TwoSided]:
    """Each controller, smoothed and cut, with unit gain at rest: a truncated series holds a position not quite."""
    F = TwoSided(uniform_basis(DEGREE, L).beta / L, (DEGREE + 1) * L // 2) if L else IDENTITY
    cut = [C.then(F).cut(DIED_OUT) for C in controllers]
    return [TwoSided(C.c / C.c.sum(), C.ahead) for C in cut]


def _levels(name: str, levels: Sequence[Sequence[TwoSided]]) -> FirCompensator:
    """From the sharpest to the smoothest, all with the same lead and tail: a stretch may change over."""
    every = [C for level in levels for C in level]
    lead = max(0, *(C.ahead for C in every)) + AT_REST
    tail = max(0, *(len(C.c) - 1 - C.ahead for C in every)) + AT_REST
    harder: Callable[[], FirCompensator] | None = None
    for level in reversed(levels):
        taps = np.zeros((len(level), lead + tail + 1))
        for row, C in zip(taps, level, strict=True):
            row[lead - C.ahead : lead - C.ahead + len(C.c)] = C.c
        design = FirCompensator(name, taps, lead, tail, harder)
        harder = _again(design)
    return design


def _again(design: FirCompensator) -> Callable[[], FirCompensator]:
    return lambda: design
