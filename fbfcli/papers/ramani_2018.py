"""Ramani 2018, Fig. 5, and every method on a plant whose zero moves: as its metric says, or not applicable.

A method's error e = E y_d on white noise has the mean square J_e^2 (Ramani 2020 Eq. 2.18). Over s draws of M + 1
samples that mean square is known within
    sd = J_e^2 sqrt(2 / s) ||E^T E||_F / ||E||_F^2
which is small for an LTI method, where E spreads over all frequencies, and large for FBF, where E has rank M - n.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import qr_multiply

from fbfcli.control.factored_plant import FactoredPlant, factored
from fbfcli.control.inversion import (
    Inverse,
    extended_zpetc,
    npz_ignore,
    stable_inversion,
    truncated_series,
    zmetc,
    zpetc,
)
from fbfcli.control.optimal_basis import accuracy
from fbfcli.control.two_sided import TwoSided
from fbfcli.errors import ModelError
from fbfcli.papers.item import Item, Progress, Result, Row, between, judged
from fbfcli.papers.zero_sweep import BASES, N_1, POLE, M, N, filtered, noise, relative_rms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NONE_CANCELLED = 2.0  # zero damping: the plant could be inverted where |a| < 1, and the study does not
PREVIEW = 20  # of stable inversion [samples]
METHODS: dict[str, Callable[[FactoredPlant], Inverse]] = {
    "NPZ-ignore": npz_ignore,
    "ZPETC": zpetc,
    "ZMETC": zmetc,
    "EBZPETC": lambda G: extended_zpetc(G, N_1),
    "TS": lambda G: truncated_series(G, N_1),
    "stable inversion": lambda G: stable_inversion(G, PREVIEW),
}
STYLES = {
    "NPZ-ignore": ":",
    "ZPETC": "-.",
    "ZMETC": (0, (5, 1)),
    "EBZPETC": (0, (3, 1, 1, 1)),
    "TS": "--",
    "stable inversion": (0, (1, 1)),
    "DCT": "o",
    "B-splines": "x",
    "block pulses": "+",
}
ABSENT = {  # where a method says that it does not apply, and why
    "NPZ-ignore": "a = 1",
    "ZPETC": "a = 1",
    "ZMETC": "|a| = 1",
    "EBZPETC": "3 - sqrt(8) < a < 3 + sqrt(8)",  # |E| > 1: 4 a > (1 - a)^2
    "TS": "|a| = 1",
    "stable inversion": "|a| = 1",
}
MOST_SD = 5.0  # a mean of the sweep may be this many standard deviations from its prediction
NOTHING = 1e-9  # errors under this are rounding


@dataclass(frozen=True)
class Sweep:
    """One method over the zeros.

    a     : ndarray, shape (k,)   zeros
    error : ndarray, shape (k,)   RMS of e_RMS / y_d,RMS over the draws; NaN where it does not apply
    J_e   : ndarray, shape (k,)   its metric
    sd    : ndarray, shape (k,)   relative standard deviation of error^2
    """

    a: np.ndarray
    error: np.ndarray
    J_e: np.ndarray
    sd: np.ndarray

    @property
    def farthest(self) -> float:
        """Largest departure of error^2 from J_e^2 [standard deviations]."""
        seen = self.J_e > NOTHING
        return float(np.max(np.abs((self.error[seen] / self.J_e[seen]) ** 2 - 1) / self.sd[seen]))


def plant(a: float) -> FactoredPlant:
    """(z - a) / (z - p), Ramani 2018 Eq. 6."""
    return factored(np.array([1.0, -a]), np.array([1.0, -POLE]), NONE_CANCELLED)


def error_dynamics(name: str, a: float) -> TwoSided | None:
    """E of a method of `inversion`; None where it does not apply."""
    try:
        return METHODS[name](plant(a)).L.error()
    except ModelError:
        return None


def metric_curve(name: str, a: np.ndarray) -> np.ndarray:
    """J_e at each zero; NaN where the method does not apply."""
    E = [error_dynamics(name, zero) for zero in a]
    return np.array([np.nan if each is None else each.frobenius(M + 1) for each in E])


def lti_sweep(name: str, a: np.ndarray, y_d: np.ndarray) -> Sweep:
    """A method of `inversion`."""
    found = np.full((len(a), 3), np.nan)
    for k, zero in enumerate(a):
        E = error_dynamics(name, zero)
        if E is not None:
            J_e = E.frobenius(M + 1)
            r = np.correlate(E.c, E.c, "full")
            sd = np.sqrt(2 / y_d.shape[1] * (r @ r) / (M + 1)) / max(J_e**2, NOTHING**2)
            e = np.sqrt(np.mean(relative_rms(E.filtered(y_d), y_d) ** 2))
            found[k] = e, J_e, sd
    return Sweep(a, *found.T)


def fbf_sweep(name: str, a: np.ndarray, y_d: np.ndarray, progress: Callable[[], None]) -> Sweep:
    """FBF with the basis of that name. E = I - Q Q^T, Phi_f = Q R, has rank M - n.

    ||e||^2 = ||y_d||^2 - ||Q^T y_d||^2: no coefficients are solved for, so QR need not be pivoted here.
    """
    Phi, found = BASES[name](), np.empty((len(a), 3))
    rank, energy = M - N, np.square(y_d).sum(axis=0)
    for k, zero in enumerate(a):
        reached, _ = qr_multiply(filtered(zero, Phi), y_d.T, mode="right")
        e = np.sqrt(np.mean(1 - np.square(reached).sum(axis=1) / energy))
        found[k] = e, accuracy(N, M), np.sqrt(2 / (len(energy) * rank))
        progress()
    return Sweep(a, *found.T)


def _swept(
    a: np.ndarray, methods: Iterable[str], bases: tuple[str, ...], seeds: int, progress: Progress
) -> dict[str, Sweep]:
    """Every method over the zeros; the bases take the time."""
    y_d, done = noise(seeds), 0

    def step() -> None:
        nonlocal done
        done += 1
        progress(done / (len(a) * len(bases)))

    found = {name: lti_sweep(name, a, y_d) for name in methods}
    return found | {name: fbf_sweep(name, a, y_d, step) for name in bases}


def _rows(found: dict[str, Sweep]) -> list[Row]:
    rows = []
    for name, sweep in found.items():
        method = f"FBF {name}" if name in BASES else name
        rows.append(
            between(
                f"{method}: e_RMS from its J_e, largest departure [standard deviations]",
                "as predicted",
                sweep.farthest,
                0,
                MOST_SD,
            )
        )
        absent = sweep.a[np.isnan(sweep.error)]
        says = ", ".join(f"{a:g}" for a in absent) or "nowhere"
        if len(absent) > 3:
            says = f"{len(absent)} zeros from {absent[0]:g} to {absent[-1]:g}"
        right = np.array_equal(np.isnan(sweep.error), _not_applicable(name, sweep.a))
        rows.append(judged(right, f"{method}: not applicable at a =", ABSENT.get(name, "nowhere"), says, "exact"))
    return rows


def _not_applicable(name: str, a: np.ndarray) -> np.ndarray:
    """Where a method is undefined, by what is written of it in ABSENT."""
    if name in ("NPZ-ignore", "ZPETC"):
        return a == 1
    if name == "EBZPETC":
        return 4 * a > (1 - a) ** 2
    return np.abs(a) == 1 if name in ABSENT else np.zeros(len(a), bool)


def _draw(axes: Axes, found: dict[str, Sweep], fine: np.ndarray) -> None:
    """LTI methods by their metric on the zeros `fine`, FBF at the zeros it was computed for."""
    for name, sweep in found.items():
        if name in BASES:
            axes.semilogy(sweep.a, sweep.error, STYLES[name], markersize=4, label=f"FBF {name}")
        else:
            axes.semilogy(fine, metric_curve(name, fine), linestyle=STYLES[name], label=name)
    axes.axvspan(-1, 1, color="0.93", zorder=0)
    axes.set(xlabel="zero $a$", ylabel="$e_{RMS} / y_{d,RMS}$", ylim=(1e-4, 1e3), xlim=(fine[0], fine[-1]))
    axes.legend(ncols=2, fontsize="small")


def _fig_5(seeds: int, progress: Progress) -> Result:
    a = np.arange(-10.0, 11.0)
    found = _swept(a, ("ZPETC", "TS"), ("DCT", "block pulses"), seeds, progress)
    rows = _rows(found)
    for name in ("DCT", "block pulses"):
        e, sd = found[name].error, found[name].sd[0] / 2  # of e itself; 21 draws of it span some 5 of them
        what = f"FBF {name}: largest e_RMS over smallest, a = -10..10"
        rows.append(between(what, "very consistent", float(e.max() / e.min()), 1, float(np.exp(5 * sd))))
    caption = (
        f"Normalised tracking error of ZPETC (Ramani 2020 Eq. 2.28) and TS (Eq. 2.29, n1 = {N_1}) by their "
        f"metric, and of FBF with DCT and block pulses (Ramani 2018 Eq. 5, n = {N}, M = {M}; mean of {seeds} draws of "
        "white noise), by the place of the zero of Eq. 6; shaded: inside the unit circle."
    )
    return Result(tuple(rows), lambda figure: _draw(figure.subplots(), found, np.arange(-500, 501) / 50), caption)


def _all_methods(seeds: int, progress: Progress) -> Result:
    a = np.unique(np.concatenate((np.arange(-5.0, 6.0), [-1.02, -0.98, -0.5, 0.5, 0.98, 1.02])))
    found = _swept(a, METHODS, tuple(BASES), seeds, progress)
    caption = (
        "Every method on (z - a) / (z - 0.5), a = -5..5 (Ramani 2020 Eq. 2.27): tracking error of white "
        f"noise, {seeds} draws, and J_e (Eq. 2.18). n1 = {N_1}, {PREVIEW} samples of preview, n = {N}, M = {M}; gaps "
        "where a method does not apply."
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(9, 6)
        _draw(figure.subplots(), found, np.arange(-250, 251) / 50)

    return Result(tuple(_rows(found)), draw, caption)


ITEMS = (
    Item(
        "ramani-2018-fig-5",
        "FBF, ZPETC and TS by the zero's place, a = -10..10",
        "Ramani 2018",
        "Eq. 5, 6",
        False,
        _fig_5,
    ),
    Item(
        "zero-sweep",
        "Every method by the zero's place, a = -5..5",
        "Ramani 2020",
        "Eq. 2.18, 2.27",
        False,
        _all_methods,
    ),
)
