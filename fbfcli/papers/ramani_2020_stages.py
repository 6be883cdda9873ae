"""Ramani 2020, Fig. 3.6 and App. H, simulated: bases at a command limit, on the printed printer model and on a stage.

The experiments' trajectory is given as a picture only, and the stage's model is in another paper. What stands in for
them: a butterfly (Fay 1989) that is cut off while it moves, as commands that grow towards their end tell of theirs; and
a stage with the features App. H tells of (four modes, one real zero outside the unit circle, a relative degree of one,
10 kHz), over a fifth of the time, with a fifth of the functions. Held to the paper are only the claims that do not rest
on the trajectory: that CE-Opt costs least effort and keeps inside the limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import svdvals
from scipy.signal import cont2discrete

from fbfcli.control.bases import dct
from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.fbf import Controller, decoupled
from fbfcli.control.lifted import causal, markov
from fbfcli.control.optimal_basis import effort_optimal
from fbfcli.papers.item import Item, Progress, Result, Row, judged, not_reproducible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Ramani 2020"
LIMIT = 10.0  # mm, of the command
LOOPS = 2.3  # rounds of the butterfly
SWING = 8.0  # mm, largest desired position
DEGREE = 5
# Eq. 3.25 within half a unit of its last printed digits: as printed it is unstable and has no unit DC gain.
TAZ6_B = np.array([0, 0.0874002643, -0.3414755673, 0.5118203207, -0.3480853557, 0.0906300805])
TAZ6_A = np.array([1, -4.5399420515, 8.2830579485, -7.5829420515, 3.4790579485, -0.6389420515])
MODES = ((60.0, 0.03, 0.55), (95.0, 0.03, 0.35), (160.0, 0.02, 0.06), (260.0, 0.02, 0.04))  # Hz, damping, weight
UNSTABLE_ZERO = 1200.0  # 1/s
STAGE_DT = 1e-4  # s


def butterfly(samples: int) -> np.ndarray:
    """x of r = exp(sin th) - 2 cos 4 th + sin^5((2 th - pi) / 24), th = 0..2 pi LOOPS, shape (samples,) [mm]."""
    s = np.linspace(0, 1, samples)
    th = 2 * np.pi * LOOPS * s
    r = np.exp(np.sin(th)) - 2 * np.cos(4 * th) + np.sin((2 * th - np.pi) / 24) ** 5
    x = r * np.cos(th) - r[0] * np.cos(th[0])
    return x * SWING / np.abs(x).max()


def stage() -> tuple[np.ndarray, np.ndarray]:
    """Modes side by side times (1 - s / zero), behind a zero-order hold: b, a of z^0, z^-1, ..."""
    numerator: np.ndarray = np.zeros(1)
    denominator: np.ndarray = np.ones(1)
    for frequency, zeta, weight in MODES:
        w = 2 * np.pi * frequency
        own = np.array([1, 2 * zeta * w, w**2])
        numerator = np.polyadd(np.polymul(numerator, own), weight * w**2 * denominator)
        denominator = np.polymul(denominator, own)
    numerator = np.polymul(numerator, [-1 / UNSTABLE_ZERO, 1])
    b, a, _ = cont2discrete((numerator, denominator), STAGE_DT)
    return b[0], a


@dataclass(frozen=True)
class Run:
    """One basis at the limit.

    J_c   : float                       control effort, Eq. 3.4
    asked : ndarray, shape (samples,)   command before the limit [mm]
    u, e  : ndarray, shape (samples,)   command behind it, tracking error [mm]
    """

    J_c: float
    asked: np.ndarray
    u: np.ndarray
    e: np.ndarray

    @property
    def largest(self) -> float:
        """Largest command asked for [mm]."""
        return float(np.abs(self.asked).max())


def _run(G: np.ndarray, controller: Controller, y_d: np.ndarray) -> Run:
    asked = controller.command(y_d)
    u = np.clip(asked, -LIMIT, LIMIT)
    return Run(float(np.linalg.norm(controller.Psi) / np.sqrt(len(G))), asked, u, y_d - G @ u)


def _bases(G: np.ndarray, n: int) -> dict[str, Controller]:
    M = len(G) - 1
    splines, cosines = bsplines(normalised_time(M), n, DEGREE), dct(M, n)
    return {
        "CE-Opt": effort_optimal(G, n),
        "B-splines": decoupled(splines, G @ splines),
        "DCT": decoupled(cosines, G @ cosines),
    }


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt((x**2).mean()))


def _table_3_2(seeds: int, progress: Progress) -> Result:
    G, n = causal(markov(TAZ6_B, TAZ6_A, 1000)), 500
    y_d = butterfly(len(G))
    runs = {name: _run(G, each, y_d) for name, each in _bases(G, n).items()}
    printed = {"CE-Opt": "0.0287, 0.9993", "B-splines": "0.0316, 1.0480", "DCT": "0.0525, 1.1227"}
    rows = _rows(runs, "Table 3.2", printed, "measured on a printer; its trajectory is a picture")
    caption = (
        f"Command and tracking error of three bases (Eq. 3.22, App. F) on the Taz 6 model (Eq. 3.25), simulated; "
        f"command limited to ±{LIMIT:g} mm, M = 1000, n = {n}, 1 kHz, a butterfly's x (Fig. 3.6)."
    )
    return Result(tuple(rows), lambda figure: _draw(figure, runs, 1e-3), caption)


def _app_h(seeds: int, progress: Progress) -> Result:
    G, n = causal(markov(*stage(), 2000)), 120
    y_d = butterfly(len(G))
    every = _bases(G, n)
    runs = {name: _run(G, every[name], y_d) for name in ("CE-Opt", "B-splines")}
    sigma = svdvals(G)
    gap = sigma[-3] / max(sigma[-2], np.finfo(float).tiny)
    progress(1.0)
    rows = [
        judged(
            bool(gap > 1e3),
            "Fig. H.4: third smallest singular value over the second smallest",
            "two deviate",
            float(gap),
            "> 1000",
        ),
        *_rows(
            runs,
            "Table H.1, X",
            {"CE-Opt": "0.06, 1.05", "B-splines": "0.17, 1.08"},
            "measured on a stage whose model is not in the paper",
        ),
    ]
    caption = (
        f"Command and tracking error of CE-Opt (Eq. 3.22) and B-splines (Eq. F.2) on a stage with one zero outside "
        f"the circle, simulated; command limited to ±{LIMIT:g} mm, M = 2000, n = {n}, 10 kHz, a butterfly (Fig. H.7)."
    )
    return Result(tuple(rows), lambda figure: _draw(figure, runs, STAGE_DT), caption)


def _rows(runs: dict[str, Run], table: str, printed: dict[str, str], why: str) -> list[Row]:
    y_rms, best = _rms(butterfly(len(runs["CE-Opt"].e))), runs["CE-Opt"]
    inside = best.largest <= LIMIT
    rows = [
        judged(inside, "CE-Opt: largest command asked for [mm]", "inside the limit", best.largest, f"at most {LIMIT:g}")
    ]
    for name in sorted(runs.keys() - {"CE-Opt"}):
        more = runs[name].J_c / best.J_c
        rows.append(judged(more > 1, f"J_c of {name} over CE-Opt's", "> 1", more, "> 1"))
        what = f"{name}: largest command asked for [mm]"
        rows.append(
            not_reproducible(what, f"beyond the limit of {LIMIT:g}", "rests on the trajectory", runs[name].largest)
        )
    for name, run in runs.items():
        ours = f"{_rms(run.e) / y_rms:.4f}, {_rms(run.u) / y_rms:.4f}"
        rows.append(not_reproducible(f"{table}, {name}: e_RMS/y_d,RMS, u_RMS/y_d,RMS", printed[name], why, ours))
    return rows


def _draw(figure: Figure, runs: dict[str, Run], dt: float) -> None:
    above, below = figure.subplots(2, 1, sharex=True)
    for name, style in (("DCT", "-."), ("B-splines", "--"), ("CE-Opt", "-")):
        if name in runs:
            t = dt * np.arange(len(runs[name].u))
            above.plot(t, runs[name].u, style, label=name)
            below.plot(t, runs[name].e, style, label=name)
    above.set(ylabel="command [mm]", ylim=(-1.1 * LIMIT, 1.1 * LIMIT))
    below.set(xlabel="time [s]", ylabel="tracking error [mm]")
    above.legend()


ITEMS = (
    Item(
        "ramani-2020-table-3.2",
        "Table 3.2 and Fig. 3.6, simulated: bases at a command limit",
        PAPER,
        "Eq. 3.22, 3.25",
        True,
        _table_3_2,
    ),
    Item(
        "ramani-2020-app-h",
        "App. H, simulated: a stage with a zero outside the circle",
        PAPER,
        "Eq. 3.22",
        False,
        _app_h,
    ),
)
