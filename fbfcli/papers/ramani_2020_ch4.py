"""Ramani 2020, chapter 4: basis functions and nominal models for a plant that is known only as a family."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fbfcli.papers.item import Item, Progress, Result, close, judged, near
from fbfcli.papers.oscillators import NAMES, NOMINALS, SIZES, M, nominal, plants

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Ramani 2020"


def _fig_4_3(seeds: int, progress: Progress) -> Result:
    robust = nominal("standard").robust
    metrics = [robust.metric(n) for n in range(len(robust.sigma))]
    rows = (
        judged(robust.best_size() == 891, "n* from the singular values below 1", "891", robust.best_size(), "exact"),
        judged(int(np.argmin(metrics)) == 891, "n of least J_e,r", "891", int(np.argmin(metrics)), "exact"),
    )
    return Result(
        rows, lambda figure: _singular_values(figure, robust.sigma), _caption("standard nominal model (Eq. 4.1)")
    )


def _fig_4_4(seeds: int, progress: Progress) -> Result:
    robust = nominal("proposed").robust
    rows = (near("largest singular value", "0.9748", float(robust.sigma[-1]), 0.9748, 1e-4),)
    return Result(
        rows, lambda figure: _singular_values(figure, robust.sigma), _caption("optimal nominal model (Eq. 4.28)")
    )


def _caption(model: str) -> str:
    return (
        f"Singular values of the normalised spread Delta_nom,s (Eq. 4.11) with the {model}; M = {M}, r = 1. "
        "Below 1 a function is worth having (Remark 4.5)."
    )


def _singular_values(figure: Figure, sigma: np.ndarray) -> None:
    axes = figure.subplots()
    axes.semilogy(np.arange(1, len(sigma) + 1), sigma[::-1], label="singular values, largest first")
    axes.axhline(1, color="0.5", linestyle="--", label="1")
    axes.set(xlabel="index", ylabel=r"singular value of $\bar\Delta_{nom,s}$")
    axes.legend()


MEANS = {  # of J_e,r over n, standard and proposed nominal model
    "DCT": (1.0048, 0.7343), "B-splines": (1.0092, 0.7381), "CE-Opt": (1.1425, 0.7541), "robust": (0.7110, 0.6913),
}  # fmt: skip


def _metrics(seeds: int, progress: Progress) -> Result:
    family, curves = plants(), {}
    for k, which in enumerate(NOMINALS):
        model = nominal(which)
        for name in NAMES:
            if name == "B-splines":
                curves[name, which] = np.array([family.metric(model.controller(name, n)) for n in SIZES])
            else:
                curves[name, which] = family.nested_metrics(model.nested[name])[list(SIZES)]
        progress((k + 1) / len(NOMINALS))
    rows = tuple(
        near(
            f"{name}, {which} nominal model: mean J_e,r, n = 10:10:990",
            None,
            float(curves[name, which].mean()),
            MEANS[name][k],
            1e-3,
        )
        for k, which in enumerate(NOMINALS)
        for name in NAMES
    )
    caption = (
        f"Metric J_e,r (Eq. 4.2) against the number of functions n for two nominal models (Eq. 4.1, 4.28) and four "
        f"bases (App. F, Eq. 3.22, Eq. 4.22); M = {M}, 410 plants."
    )
    return Result(rows, lambda figure: _against_size(figure, curves, "$J_{e,r}$"), caption)


def _against_size(figure: Figure, curves: dict[tuple[str, str], np.ndarray], label: str) -> None:
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, which in ((left, NOMINALS[0]), (right, NOMINALS[1])):
        for name in NAMES:
            axes.plot(SIZES, curves[name, which], label=name)
        axes.set(xlabel="$n$", title=f"{which} nominal model")
    left.set(ylabel=label)
    left.legend()


def _efforts(seeds: int, progress: Progress) -> Result:
    expected = {
        ("CE-Opt", "standard"): 12.187,
        ("CE-Opt", "proposed"): 9.2765,
        ("robust", "standard"): 27.53,
        ("robust", "proposed"): 11.142,
    }
    rows = []
    for (name, which), J_c in expected.items():
        Psi = nominal(which).controller(name, 990).Psi
        ours = float(np.linalg.norm(Psi) / np.sqrt(M + 1))
        rows.append(close(f"{name}, {which} nominal model: J_c at n = 990", None, ours, J_c, 1e-3))
    return Result(tuple(rows))


ITEMS = (
    Item(
        "ramani-2020-fig-4.3",
        "Singular values of the spread, standard nominal model",
        PAPER,
        "Eq. 4.11, 4.25",
        True,
        _fig_4_3,
    ),
    Item(
        "ramani-2020-fig-4.4",
        "Singular values of the spread, optimal nominal model",
        PAPER,
        "Eq. 4.11, 4.28",
        True,
        _fig_4_4,
    ),
    Item(
        "ramani-2020-eq-4.2",
        "J_e,r of eight controllers against their size",
        PAPER,
        "Eq. 4.2, 4.22, 4.28",
        False,
        _metrics,
    ),
    Item(
        "ramani-2020-eq-3.4-robust",
        "Control effort J_c of the chapter's controllers",
        PAPER,
        "Eq. 3.4, 4.22, 4.28",
        True,
        _efforts,
    ),
)
