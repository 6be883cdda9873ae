"""Duan 2015, Sec. 4.2 and 4.3: how many control points, initial conditions and higher-order derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fbfcli.control.fbf import coefficients, constrained, output_space, with_derivatives
from fbfcli.papers.duan_2015_plant import E, basis, desired, plant, rms, time_ms
from fbfcli.papers.item import Item, Progress, Result, Row, between, judged, not_reproducible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Duan 2015"
LHP = -1.1
COUNTS = (10, 100, 200, 300)  # n of Figs. 9 and 10
FEW = 15  # n of Table 5
ALPHA = (1.0, 2e-4, 2e-5)  # of position, velocity and acceleration, Eq. 36
UNITS = ("mm", "mm/s", "mm/s^2")
NAMES = ("position", "velocity", "acceleration")
TABLE_5 = {  # RMS, largest of each derivative
    "basic": ((4.66e-3, 1.15e-2), (7.24, 54.0), (1.20e4, 8.34e4)),
    "with initial conditions": ((6.25e-3, 1.89e-2), (6.18, 20.0), (6.97e3, 3.23e4)),
    "with derivatives": ((6.49e-3, 1.99e-2), (5.98, 20.5), (6.08e3, 2.00e4)),
}
WHY = "rests on the path, which is given only as a drawing"


def _projections(seeds: int, progress: Progress) -> Result:
    spaces = {n: output_space(plant(LHP).filtered(basis(n))) for n in COUNTS}
    H = {n: Q @ Q.T for n, Q in spaces.items()}
    rows = [between(f"trace of H less n + 1, n = {n}", "0", float(np.trace(H[n]) - n - 1), -1e-9, 1e-9) for n in COUNTS]
    rows += [
        between(f"largest element of H^2 - H, n = {n}", "0", float(np.abs(H[n] @ H[n] - H[n]).max()), 0, 1e-12)
        for n in COUNTS
    ]
    least = [float(np.median(np.diag(H[n]))) for n in COUNTS]
    rows.append(
        judged(
            least == sorted(least),
            "median of H's diagonal rises with n",
            "rises",
            ", ".join(f"{v:.3f}" for v in least),
            "ordering",
        )
    )
    caption = "Elements of H (Eq. 11) for the zero at -1.1 and n = 10, 100, 200, 300: it nears the identity as n grows."

    def draw(figure: Figure) -> None:
        figure.set_size_inches(9, 8)
        for axes, n in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, COUNTS, strict=True):
            image = axes.imshow(H[n], vmax=np.median(np.diag(H[n])), cmap="viridis", interpolation="nearest")
            axes.set(title=f"n = {n}", xlabel="column (sample of $x_d$)", ylabel="row (sample of $x$)")
            figure.colorbar(image, ax=axes, label="element of H", extend="max")

    return Result(tuple(rows), draw, caption)


def _counts(seeds: int, progress: Progress) -> Result:
    y_d, errors = desired("x"), {}
    for n in COUNTS:
        Phi_f = plant(LHP).filtered(basis(n))
        errors[n] = y_d - Phi_f @ coefficients(Phi_f, y_d)
    e = [rms(errors[n]) for n in COUNTS]
    gains = [e[k] / e[k + 1] for k in range(len(e) - 1)]
    rows = (
        judged(gains[0] > 100, "RMS error at n = 10 over n = 100", "very significant", gains[0], "> 100"),
        judged(
            max(gains[1:]) < gains[0] / 10,
            "RMS error at n = 100 over 200, and 200 over 300",
            "dwindle",
            ", ".join(f"{g:.3g}" for g in gains[1:]),
            "a tenth of the first",
        ),
    )
    caption = (
        "Error of the x axis for the zero at -1.1 by the number of control points (Eq. 10): splines of degree "
        "4, n = 10, 100, 200, 300."
    )

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for n in COUNTS:
            axes.semilogy(time_ms(), np.maximum(np.abs(errors[n]), 1e-12), label=f"n = {n}")
        axes.set(xlabel="time [ms]", ylabel="|tracking error| [mm]")
        axes.legend()

    return Result(rows, draw, caption)


def _solutions() -> dict[str, np.ndarray]:
    """Control points of the three ways, shape (n + 1,) each."""
    bases = [basis(FEW, order) for order in range(3)]
    y = [desired("x", order) for order in range(3)]
    filtered = [plant(LHP).filtered(Phi) for Phi in bases]
    Q, z = np.array([Phi[0] for Phi in bases]), np.array([each[0] for each in y])  # Eq. 30
    stacked = with_derivatives(list(zip(ALPHA, filtered, y, strict=True)))
    return {
        "basic": coefficients(filtered[0], y[0]),
        "with initial conditions": constrained(filtered[0], y[0], Q, z),
        "with derivatives": coefficients(*stacked),
    }


def _derivatives(seeds: int, progress: Progress) -> Result:
    errors = {
        name: [desired("x", order) - plant(LHP).filtered(basis(FEW, order)) @ p for order in range(3)]
        for name, p in _solutions().items()
    }
    rows = [
        not_reproducible(f"{name}: {NAMES[r]} error {kind} [{UNITS[r]}]", f"{TABLE_5[name][r][k]:.2e}", WHY, ours)
        for name, e in errors.items()
        for r in range(3)
        for k, (kind, ours) in enumerate((("RMS", rms(e[r])), ("max", float(np.abs(e[r]).max()))))
    ]
    rows += [_ordering(errors, r, rising=r == 0) for r in range(3)]
    sizes = [rms(errors["basic"][r]) / TABLE_5["basic"][r][0] for r in range(3)]
    rows += [
        between(f"basic: {NAMES[r]} error RMS, ours over the paper's", "1", sizes[r], 0.1, 10, "order of magnitude")
        for r in range(3)
    ]
    caption = (
        "Position, velocity and acceleration errors of the x axis, zero at -1.1, n = 15: basic (Eq. 10), with "
        "initial conditions (Eq. 31), with derivatives (Eq. 36, alpha 2e-4 s and 2e-5 s^2)."
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(8, 8)
        for r, axes in enumerate(figure.subplots(3, 1, sharex=True)):
            for name, style in zip(errors, ("-", "--", ":"), strict=True):
                axes.plot(time_ms(), errors[name][r], style, label=name)
            axes.set_ylabel(f"{NAMES[r]} error\n[{UNITS[r]}]")
        axes.set_xlabel("time [ms]")
        figure.axes[0].legend()

    return Result(tuple(rows), draw, caption)


def _ordering(errors: dict[str, list[np.ndarray]], r: int, rising: bool) -> Row:
    """Position gets worse, velocity and acceleration get better, from way to way."""
    e = [rms(errors[name][r]) for name in TABLE_5]
    as_printed = e == sorted(e, reverse=not rising)
    return judged(
        as_printed,
        f"{NAMES[r]} error RMS over the three ways",
        "rises" if rising else "falls",
        ", ".join(f"{v:.4g}" for v in e),
        "ordering",
    )


ITEMS = (
    Item("duan-2015-fig-9", f"The matrix H ({E + 1} samples) by n", PAPER, "Eq. 11", True, _projections),
    Item("duan-2015-fig-10", "Error by the number of control points", PAPER, "Eq. 10", True, _counts),
    Item(
        "duan-2015-table-5", "Initial conditions and derivatives, Fig. 11", PAPER, "Eq. 10, 30-36", True, _derivatives
    ),
)
