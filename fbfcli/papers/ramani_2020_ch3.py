"""Ramani 2020, chapter 3: what the basis costs in control effort, and the basis that costs least (CE-Opt)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigvalsh, svdvals

from fbfcli.control.fbf import Controller, decoupled, output_space
from fbfcli.control.lifted import causal, markov, metric
from fbfcli.control.optimal_basis import effort_optimal, least_effort
from fbfcli.papers.item import Item, Progress, Result, Row, between, close, judged, near
from fbfcli.papers.zero_sweep import BASES, POLE, M, N, filtered, noise, relative_rms, zeros

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Ramani 2020"
FINE, COARSE, BENDS = 0.02, 0.1, 1.5  # steps of a, and where |a| changes from one to the other
NAMES = ("DCT", "B-splines", "CE-Opt")
STYLES = {"DCT": "-", "B-splines": "--", "CE-Opt": "-"}


def _plant(a: float) -> np.ndarray:
    return causal(markov(np.array([1.0, -a]), np.array([1.0, -POLE]), M))


def _controllers(a: float, bases: dict[str, np.ndarray]) -> dict[str, Controller]:
    found = {name: decoupled(Phi, filtered(a, Phi)) for name, Phi in bases.items()}
    return found | {"CE-Opt": effort_optimal(_plant(a), N)}


@dataclass(frozen=True)
class Sweep:
    """What each basis does at each zero.

    a       : ndarray, shape (k,)
    weights : ndarray, shape (k,)         of a mean over a, sum 1
    J_c     : per basis, shape (k,)       control effort, Eq. 3.4
    e, u    : per basis, shape (k, seeds) e_RMS and u_RMS over y_d,RMS
    """

    a: np.ndarray
    weights: np.ndarray
    J_c: dict[str, np.ndarray]
    e: dict[str, np.ndarray]
    u: dict[str, np.ndarray]


def _graded() -> tuple[np.ndarray, np.ndarray]:
    """Zeros in steps of 0.02 where the curves bend, 0.1 elsewhere, and the weights of a mean over steps of 0.02."""
    fine, coarse = zeros(FINE), zeros(COARSE)
    a = np.concatenate((fine[np.abs(fine) <= BENDS], coarse[np.abs(coarse) > BENDS + COARSE / 2]))
    a.sort()
    edges = np.concatenate((a[:1] - FINE / 2, (a[1:] + a[:-1]) / 2, a[-1:] + FINE / 2))
    return a, np.diff(edges) / (edges[-1] - edges[0])


def _swept(seeds: int, progress: Progress) -> Sweep:
    (a, weights), y_d = _graded(), noise(seeds)
    bases = {name: BASES[name]() for name in ("DCT", "B-splines")}
    J_c = {name: np.empty(len(a)) for name in NAMES}
    e, u = ({name: np.empty((len(a), seeds)) for name in NAMES} for _ in range(2))
    for k, zero in enumerate(a):
        for name, controller in _controllers(zero, bases).items():
            J_c[name][k] = np.linalg.norm(controller.Psi) / np.sqrt(M + 1)  # ||C||_F = ||Psi||_F, Eq. 3.2
            e[name][k] = relative_rms(y_d - controller.output(y_d), y_d)
            u[name][k] = relative_rms(controller.command(y_d), y_d)
        progress((k + 1) / len(a))
    return Sweep(a, weights, J_c, e, u)


def _table_3_1(seeds: int, progress: Progress) -> Result:
    swept = _swept(seeds, progress)
    rows = [
        *(_error_row(name, paper, swept) for name, paper in zip(NAMES, ("7.83e-2", "8.14e-2", "8.28e-2"), strict=True)),
        _effort_row("DCT", "2.76e1", swept, 6.5, 252),
        _effort_row("B-splines", "1.02e5", swept, 5.8e4, 1.1e6),
        _effort_row("CE-Opt", "7.06e-1", swept, 0.70, 0.77),
    ]
    caption = (
        f"Effect of the basis on (a) J_e (Eq. 2.21), (b) J_c (Eq. 3.4; CE-Opt: Eq. 3.22), (c) tracking error and "
        f"(d) control input for zeros a; M = {M}, n = {N}, mean of {seeds} draws of white noise (Figs 3.1, 3.2, 3.3). "
        "Splines: the effort falls where the solver drops a function that has vanished in double precision."
    )
    return Result(tuple(rows), lambda figure: _draw(figure, swept), caption)


# Means over a, and their sd over draws, as computed independently of this package: the paper's one draw is unknown.
INDEPENDENT = {"DCT": (0.097, 0.02), "B-splines": (0.108, 0.02), "CE-Opt": (0.097, 0.02)}


def _error_row(name: str, paper: str, swept: Sweep) -> Row:
    """The mean over a of e, a mean over draws within its spread."""
    mean, sd = INDEPENDENT[name]
    draws = swept.weights @ swept.e[name]
    what = f"Table 3.1, {name}: mean e_RMS/y_d,RMS"
    return between(what, paper, float(draws.mean()), mean - sd, mean + sd, f"sd over draws {draws.std():.3f}")


def _effort_row(name: str, paper: str, swept: Sweep, low: float, high: float) -> Row:
    draws = swept.weights @ swept.u[name]
    note = f"draws {draws.min():.3g} .. {draws.max():.3g}"
    return between(f"Table 3.1, {name}: mean u_RMS/y_d,RMS", paper, float(draws.mean()), low, high, note)


def _draw(figure: Figure, swept: Sweep) -> None:
    (a_e, a_c), (a_error, a_input) = figure.subplots(2, 2, sharex=True)
    J_e = np.full(len(swept.a), np.sqrt(1 - (N + 1) / (M + 1)))
    for name in NAMES:
        a_e.semilogy(swept.a, J_e, STYLES[name], label=name)
        a_c.semilogy(swept.a, swept.J_c[name], STYLES[name], label=name)
        a_error.semilogy(swept.a, swept.e[name].mean(axis=1), STYLES[name], label=name)
        a_input.semilogy(swept.a, swept.u[name].mean(axis=1), STYLES[name], label=name)
    for axes, label in ((a_e, "(a) $J_e$"), (a_c, "(b) $J_c$")):
        axes.set(ylabel=label)
    a_error.set(xlabel="zero $a$", ylabel="(c) $e_{RMS} / y_{d,RMS}$", ylim=(1e-3, 1))
    a_input.set(xlabel="zero $a$", ylabel="(d) $u_{RMS} / y_{d,RMS}$")
    a_e.set(ylim=(1e-3, 1))
    a_e.legend()


def _singular_values(a: float) -> np.ndarray:
    """Largest first, as roots of eigenvalues: a third of the time; the smallest, which squares lose, are not used."""
    G = _plant(a)
    return np.sqrt(np.maximum(eigvalsh(G @ G.T, check_finite=False)[::-1], 0))


def _least_efforts(seeds: int, progress: Progress) -> Result:
    a = zeros(FINE)
    J_c = np.empty(len(a))
    for k, zero in enumerate(a):
        J_c[k] = least_effort(_singular_values(zero), N)
        progress((k + 1) / len(a))
    caption = (
        f"Least control effort J_c (Eq. 3.4, 3.23) of any {N + 1} functions for zeros a: CE-Opt's; M = {M} (Fig. 3.2b)."
    )

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        axes.semilogy(a, J_c, label="CE-Opt")
        axes.set(xlabel="zero $a$", ylabel="$J_c$")
        axes.legend()

    return Result((near("CE-Opt: mean J_c over a = -5:0.02:5", None, float(J_c.mean()), 0.7349, 1e-3),), draw, caption)


def _one_zero(seeds: int, progress: Progress) -> Result:
    """a = 1.02, where Ramani 2020 Sec. 3.2 compares the bases."""
    a, y_d = 1.02, noise(seeds)
    bases = {name: BASES[name]() for name in ("DCT", "B-splines")}
    found = _controllers(a, bases)
    J_c = {name: metric(each.C) for name, each in found.items()}
    sigma = svdvals(_plant(a))
    u = {name: relative_rms(each.command(y_d), y_d) for name, each in found.items()}
    draws = u["B-splines"] / u["DCT"]
    e = {name: relative_rms(y_d - each.output(y_d), y_d) for name, each in found.items()}
    alike = max(e["DCT"].mean(), e["B-splines"].mean()) / min(e["DCT"].mean(), e["B-splines"].mean())
    rows = (
        close(
            "a = 1.02: J_c of B-splines over DCT", "11800 (u of one draw)", J_c["B-splines"] / J_c["DCT"], 9548.6, 1e-3
        ),
        between(
            "a = 1.02: u_RMS of B-splines over DCT, median of draws",
            "11800",
            float(np.median(draws)),
            11800 / 3,
            11800 * 3,
            f"draws {draws.min():.3g} .. {draws.max():.3g}",
        ),
        judged(alike < 1.5, "a = 1.02: larger over smaller e_RMS of the two", "similar", float(alike), "< 1.5"),
        close("a = 1.02: J_c of CE-Opt against Eq. 3.23", "formula", J_c["CE-Opt"], least_effort(sigma, N), 1e-9),
        close("a = 1.02: J_e of CE-Opt", "0.09995", _error_metric(bases, a), np.sqrt(1 - 991 / 1001), 1e-9),
    )
    return Result(rows)


def _error_metric(bases: dict[str, np.ndarray], a: float) -> float:
    Q = output_space(effort_optimal(_plant(a), N).Psi_f)
    return metric(np.eye(M + 1) - Q @ Q.T)


ITEMS = (
    Item("ramani-2020-sec-3.2", "What the basis costs at a = 1.02", PAPER, "Eq. 3.4, 3.22, 3.23", True, _one_zero),
    Item(
        "ramani-2020-fig-3.2",
        "Least control effort against the zero's place",
        PAPER,
        "Eq. 3.4, 3.23",
        False,
        _least_efforts,
    ),
    Item(
        "ramani-2020-table-3.1",
        "Table 3.1 and Figs 3.1-3.3: effort of three bases",
        PAPER,
        "Eq. 2.18, 3.4, 3.22",
        False,
        _table_3_1,
    ),
)
