"""Ramani 2020, chapter 2 and App. C: tracking that does not depend on where the plant's zero is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fbfcli.control.bases import dct
from fbfcli.control.fbf import coefficients, decoupled, depends, output_space
from fbfcli.control.lifted import causal, markov, metric, non_causal, observability
from fbfcli.control.optimal_basis import accuracy
from fbfcli.papers.item import Item, Progress, Result, Row, between, close, judged, not_reproducible
from fbfcli.papers.ramani_2018 import error_dynamics
from fbfcli.papers.zero_sweep import (
    BASES,
    M,
    N,
    filtered,
    noise,
    relative_rms,
    series_metric,
    zeros,
    zpetc_metric,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Ramani 2020"
STYLES = {"DCT": "-", "B-splines": "--", "block pulses": ":", "ZPETC": "-.", "TS": (0, (1, 1))}
LTI = {"ZPETC": zpetc_metric, "TS": series_metric}
Curves = dict[str, np.ndarray]


def _error_norms(seeds: int, progress: Progress) -> Result:
    a, y_d = zeros(0.1), noise(seeds)
    bases = {name: BASES[name]() for name in ("DCT", "B-splines")}
    found: Curves = {name: np.full((len(a), seeds), np.nan) for name in (*bases, *LTI)}
    for k, zero in enumerate(a):
        for name, Phi in bases.items():
            y = decoupled(Phi, filtered(zero, Phi)).output(y_d)
            found[name][k] = relative_rms(y_d - y, y_d)
        for name in LTI:
            if E := error_dynamics(name, zero):
                found[name][k] = relative_rms(E.filtered(y_d), y_d)
        progress((k + 1) / len(a))
    mean = {name: values.mean(axis=1) for name, values in found.items()}
    rows = [_consistent(name, mean[name], found[name]) for name in bases]
    rows += [_as_predicted(name, a, mean[name]) for name in LTI]
    caption = (
        "Effect of the zero's place a on the tracking error of FBF (Eq. 2.10), ZPETC (Eq. 2.28) and TS (Eq. 2.29); "
        f"M = {M}, n = {N}, n1 = 5, mean of {seeds} draws of white noise. ZPETC is not applicable at a = 1, "
        "TS at |a| = 1; where it is shaded the plant could be inverted."
    )
    return Result(tuple(rows), lambda figure: _draw(figure, a, mean, "$e_{RMS} / y_{d,RMS}$"), caption)


def _consistent(name: str, mean: np.ndarray, found: np.ndarray) -> Row:
    """FBF's error has no trend in a: its whole sweep stays within a quarter of its mean."""
    spread = mean.max() / mean.min()
    note = f"mean {mean.mean():.4f}, sd over draws {found.mean(axis=0).std():.4f}"
    return judged(
        spread < 1.25, f"{name}: largest e_RMS over smallest, a = -5..5", "consistent", spread, "< 1.25", note
    )


def _as_predicted(name: str, a: np.ndarray, mean: np.ndarray) -> Row:
    """An LTI method's error on white noise is its metric's."""
    used = np.isfinite(mean) & (a != 0)
    off = max(abs(mean[k] / LTI[name](a[k]) - 1) for k in np.flatnonzero(used))
    absent = f"not applicable at a = {', '.join(f'{zero:g}' for zero in a[~np.isfinite(mean)])}"
    return judged(off < 0.05, f"{name}: largest departure of e_RMS from its J_e", "in agreement", off, "< 0.05", absent)


def _metrics(seeds: int, progress: Progress) -> Result:
    a = np.unique(np.append(zeros(1.0), [-1.1, 1.02, 1.1]))
    bases = {name: make() for name, make in BASES.items()}
    found: Curves = {name: np.full(len(a), np.nan) for name in (*bases, *LTI)}
    for k, zero in enumerate(a):
        for name, Phi in bases.items():
            Q = output_space(filtered(zero, Phi))
            found[name][k] = metric(np.eye(M + 1) - Q @ Q.T)
        for name in LTI:
            if E := error_dynamics(name, zero):
                found[name][k] = metric(non_causal(E.c, E.ahead, M))
        progress((k + 1) / len(a))
    rows = [_farthest(name, found[name]) for name in bases]
    rows += [_formula(name, a, found[name]) for name in LTI]
    fine = zeros(0.02)
    lti = {name: np.array([J_e(z) if error_dynamics(name, z) else np.nan for z in fine]) for name, J_e in LTI.items()}
    caption = (
        f"Effect of the zero's place a on J_e (Eq. 2.18) of FBF (Eq. 2.21; computed at the points), ZPETC (Eq. 2.28) "
        f"and TS (Eq. 2.29); M = {M}, n = {N}, n1 = 5."
    )

    def draw(figure: Figure) -> None:
        _draw(figure, fine, lti, "$J_e$")
        for name, marker in zip(bases, ("o", "x", "+"), strict=True):
            figure.axes[0].plot(a, found[name], marker, label=f"FBF {name}")
        figure.axes[0].legend()

    return Result(tuple(rows), draw, caption)


def _farthest(name: str, J_e: np.ndarray) -> Row:
    """The value that is farthest from Eq. 2.21."""
    expected = accuracy(N, M)
    note = "2 to 3 functions vanish in double precision; a command of those that remain has J_e 0.1095 to 0.1140"
    farthest = float(J_e[np.argmax(np.abs(J_e - expected))])
    return close(f"{name}: J_e, any a", "0.09995", farthest, expected, 1e-9, note if name == "B-splines" else "")


def _formula(name: str, a: np.ndarray, J_e: np.ndarray) -> Row:
    """The Toeplitz matrix of E against the formula."""
    used = np.isfinite(J_e) & (a != 0)
    off = max(abs(J_e[k] / LTI[name](a[k]) - 1) for k in np.flatnonzero(used))
    number = {"ZPETC": "2.28", "TS": "2.29"}[name]
    return between(f"{name}: J_e of E's Toeplitz matrix against Eq. {number}", "formula", off, 0, 1e-9)


def _draw(figure: Figure, a: np.ndarray, curves: Curves, label: str) -> None:
    axes = figure.subplots()
    for name, values in curves.items():
        axes.semilogy(a, values, linestyle=STYLES[name], label=name if name in LTI else f"FBF {name}")
    axes.axvspan(-1, 1, color="0.92", zorder=0)
    axes.set(xlabel="zero $a$", ylabel=label, xlim=(-5, 5), ylim=(1e-4, 1e2))
    axes.legend()


def _rank_test(seeds: int, progress: Progress) -> Result:
    """App. C: p = 0.5, a = 2, M = 100, DCT; G = K (q - a) / (q - p)."""
    p, a, last = 0.5, 2.0, 100
    K = (1 - p) / (1 - a)
    A, C = np.array([[p]]), np.array([[K * (p - a)]])  # B = 1, D = K
    G = causal(markov(K * np.array([1.0, -a]), np.array([1.0, -p]), last))
    Gamma = observability(A, C, last)
    cases = ((50, 0.0, False), (100, 0.0, True), (100, 1e-3, False))
    rows = []
    for n, state, paper in cases:
        Phi = dct(last, n)
        ours = depends(Phi, np.full((1, n + 1), state), G, Gamma)
        what = f"filtered DCT with n = {n}, initial states {state:g}: dependent"
        rows.append(judged(ours == paper, what, str(paper), str(ours), "exact"))
    Phi_f = G @ dct(last, last) + Gamma @ np.full((1, last + 1), 1e-3)
    y_d = np.sign(np.random.default_rng(0).standard_normal(last + 1))
    e = y_d - Phi_f @ coefficients(Phi_f, y_d)
    perfect = "RMS error of a binary trajectory, n = 100 from 1e-3"
    rows.append(between(perfect, "2.37e-15", float(np.sqrt((e**2).mean())), 0, 1e-9, "any trajectory is met exactly"))
    why = "the trajectory (Ref. 71) is not in the dissertation, and this error depends on it"
    rows.append(not_reproducible("RMS error of a PRBS trajectory, n = 50 [mm]", "2.49e-4", why))
    return Result(tuple(rows))


ITEMS = (
    Item(
        "ramani-2020-fig-2.3",
        "Tracking error against the zero's place",
        PAPER,
        "Eq. 2.10, 2.28, 2.29",
        False,
        _error_norms,
    ),
    Item("ramani-2020-fig-2.4", "J_e against the zero's place", PAPER, "Eq. 2.18, 2.21, 2.28, 2.29", True, _metrics),
    Item("ramani-2020-app-c", "Rank test for unique coefficients", PAPER, "Eq. 2.17, C.1-C.5", True, _rank_test),
)
