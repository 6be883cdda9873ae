"""Duan 2015, Sec. 4.1: state space, rank test, tracking errors and bandwidths against approximate inversion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fbfcli.control.fbf import coefficients, output_space
from fbfcli.papers.duan_2015_plant import (
    RATE,
    SIDES,
    ZEROS,
    E,
    N,
    Plant,
    basis,
    desired,
    lti_error,
    plant,
    rms,
    time_ms,
)
from fbfcli.papers.item import Item, Progress, Result, Row, judged, near, not_reproducible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Duan 2015"
STYLES = {"NPZ-ignore": ":", "ZPETC": "-.", "ZMETC": "--", "FBF": "-"}
TABLE_2 = {1.1: (3.0, -5.0), -1.1: (0.38, 0.24)}  # C_d, D_d
TABLE_3 = {  # RMS error [mm] by method, of x and y
    1.1: {
        "NPZ-ignore": (2.93e-1, 1.31e-1),
        "ZPETC": (6.54e-2, 3.58e-2),
        "ZMETC": (5.74e-1, 2.55e-1),
        "FBF": (2.90e-3, 3.19e-4),
    },
    -1.1: {
        "NPZ-ignore": (1.39e-2, 6.30e-3),
        "ZPETC": (1.48e-4, 8.13e-5),
        "ZMETC": (2.79e-2, 1.25e-2),
        "FBF": (7.07e-8, 1.42e-8),
    },
}
TABLE_4 = {1.1: (152, 98, 67, 5000, 152), -1.1: (2504, 1823, 1317, 5000, 1744)}  # NPZ, ZPETC, ZMETC, FBF best, worst
MAGNITUDE, PHASE = np.sqrt(2.0), np.pi / 4  # Fig. 6: 3.0103 dB and 45 degrees
PRINTED_PHASE = 49.8  # degrees, what two of the three methods' printed bandwidths amount to
STEP_HZ = 0.1
ROWS_STEP_HZ = 0.5  # for the 501 rows of H
OTHER_PATH = "the path is given only as a drawing; ours is another one of the same speed and acceleration"


def _state_space(seeds: int, progress: Progress) -> Result:
    rows = []
    for zero in ZEROS:
        _, _, C, D = plant(zero).state_space
        for name, ours, paper in (("C_d", C, TABLE_2[zero][0]), ("D_d", D, TABLE_2[zero][1])):
            what = f"{name}, a = {zero} ({SIDES[zero]})"
            rows.append(near(what, f"{paper:g}", ours, paper, 0.005))
        U = basis(N)
        F = U[:1] * (1 - D) / C  # u_i(0) = y_i(0) = C_d f_i(0) + D_d u_i(0)
        silent = np.concatenate((zero ** np.arange(E + 1.0), [-D / C]))  # Eq. 38: input and state of no output
        without = np.linalg.matrix_rank(np.vstack((U, F)))
        with_it = np.linalg.matrix_rank(np.column_stack((np.vstack((U, F)), silent / np.linalg.norm(silent))))
        rows.append(
            judged(
                (without, with_it) == (201, 202),
                f"ranks of Eq. 39, a = {zero}",
                "201, 202",
                f"{without}, {with_it}",
                "exact",
            )
        )
    return Result(tuple(rows))


def _errors(zero: float, axis: str) -> dict[str, np.ndarray]:
    """Tracking error [mm] of each method."""
    y_d, G, Phi_f = desired(axis), plant(zero), plant(zero).filtered(basis(N))
    found = {name: lti_error(inverse, y_d) for name, inverse in G.inverses().items()}
    return found | {"FBF": y_d - Phi_f @ coefficients(Phi_f, y_d)}


def _tracking(seeds: int, progress: Progress) -> Result:
    errors = {(zero, axis): _errors(zero, axis) for zero in ZEROS for axis in "xy"}
    rows = []
    for zero in ZEROS:
        for name, printed in TABLE_3[zero].items():
            for axis, paper in zip("xy", printed, strict=True):
                ours, what = rms(errors[zero, axis][name]), f"{name} {axis} RMS error, a = {zero} [mm]"
                if name == "FBF":
                    rows.append(not_reproducible(what, f"{paper:.2e}", OTHER_PATH, ours))
                    continue
                fits = abs(ours / paper - 1) <= 0.1
                rows.append(judged(fits, what, f"{paper:.2e}", ours, f"{paper:g} ± 10 %", OTHER_PATH))
        rows += [_order(zero, axis, errors[zero, axis]) for axis in "xy"]
    caption = (
        "Tracking errors of NPZ-ignore, ZPETC, ZMETC (Table 1) and FBF with a B-spline of degree 4 and 201 "
        "control points (Eq. 10) for a zero at 1.1 (RHP, Fig. 4) and at -1.1 (LHP, Fig. 5); plant Eq. 37."
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(10, 7)
        for axes, ((zero, axis), found) in zip(figure.subplots(2, 2, sharex=True).flat, errors.items(), strict=True):
            for name, e in found.items():
                axes.plot(time_ms(), e, STYLES[name], label=name)
            axes.set(title=f"{axis} axis, a = {zero} ({SIDES[zero]})", ylabel="tracking error [mm]")
            axes.grid(alpha=0.3)
        for axes in figure.axes[2:]:
            axes.set_xlabel("time [ms]")
        figure.axes[0].legend()

    return Result(tuple(rows), draw, caption)


def _order(zero: float, axis: str, found: dict[str, np.ndarray]) -> Row:
    """FBF is better than the best of the others by an order of magnitude."""
    best = min(rms(e) for name, e in found.items() if name != "FBF")
    ratio = best / rms(found["FBF"])
    what = f"best other method's error over FBF's, {axis}, a = {zero}"
    return judged(ratio >= 10, what, "one order of magnitude or more", ratio, ">= 10")


def row_responses(H: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """f [Hz], and the response of each row of H as a filter of x_d about its own sample, shape (E + 1, len(f))."""
    n = round(RATE / step)
    f = np.fft.rfftfreq(n, 1 / RATE)
    turned = np.exp(-2j * np.pi * np.outer(np.arange(len(H)), f / RATE))
    return f, np.conj(np.fft.rfft(H, n, axis=1)) * turned


def bandwidth(f: np.ndarray, L: np.ndarray, phase: float = PHASE) -> np.ndarray:
    """Lowest frequency where |L| leaves +-3.01 dB or its phase +-45 degrees (Fig. 6); the last one if it never does."""
    size = np.abs(L)
    outside = (size > MAGNITUDE) | (size < 1 / MAGNITUDE) | (np.abs(np.angle(L)) > phase)
    return np.asarray(np.where(outside.any(axis=-1), f[np.argmax(outside, axis=-1)], f[-1]))


def _bandwidths(seeds: int, progress: Progress) -> Result:
    f = np.arange(0, RATE / 2 + STEP_HZ / 2, STEP_HZ)
    curves: dict[float, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    rows: list[Row] = []
    for zero in ZEROS:
        G = plant(zero)
        lti = {name: inverse.L.response(2 * np.pi * f / RATE) for name, inverse in G.inverses().items()}
        g, H = _row_responses_of(G)
        reach = bandwidth(g, H)
        rows += _bandwidth_rows(zero, f, lti, reach)
        curves[zero] = {name: (f, L) for name, L in lti.items()}
        curves[zero] |= {"FBF best": (g, H[np.argmax(reach)]), "FBF worst": (g, H[np.argmin(reach)])}
    caption = (
        "Overall frequency response of NPZ-ignore, ZPETC, ZMETC (Table 1) and of the best and worst row of H "
        "(Eq. 11; B-spline of degree 4, 201 control points) for a = 1.1 (Fig. 7) and a = -1.1 (Fig. 8); shaded: "
        "within 3.01 dB and 45 degrees (Fig. 6)."
    )
    return Result(tuple(rows), lambda figure: _draw_responses(figure, curves), caption)


def _row_responses_of(G: Plant) -> tuple[np.ndarray, np.ndarray]:
    Q = output_space(G.filtered(basis(N)))
    return row_responses(Q @ Q.T, ROWS_STEP_HZ)


def _bandwidth_rows(zero: float, f: np.ndarray, lti: dict[str, np.ndarray], fbf: np.ndarray) -> list[Row]:
    npz, zp, zm, best, worst = TABLE_4[zero]
    of = f"bandwidth, a = {zero} ({SIDES[zero]}) [Hz]"
    reach = {name: float(bandwidth(f, L)) for name, L in lti.items()}
    wider = {name: float(bandwidth(f, L, np.radians(PRINTED_PHASE))) for name, L in lti.items()}
    why = f"the stated limit of 45 degrees does not give the printed value; {PRINTED_PHASE:g} degrees give {{:.0f}}"
    expected_zp, expected_worst = {1.1: (97.7, 151.5), -1.1: (1823.0, 1743.5)}[zero]
    return [
        not_reproducible(f"NPZ-ignore {of}", npz, why.format(wider["NPZ-ignore"]), reach["NPZ-ignore"]),
        near(f"ZPETC {of}", zp, reach["ZPETC"], expected_zp, 0.5),
        not_reproducible(f"ZMETC {of}", zm, why.format(wider["ZMETC"]), reach["ZMETC"]),
        near(f"FBF best {of}", best, float(fbf.max()), 5000.0, 1.0),
        near(f"FBF worst {of}", worst, float(fbf.min()), expected_worst, 1.0),
    ]


def _draw_responses(figure: Figure, curves: dict[float, dict[str, tuple[np.ndarray, np.ndarray]]]) -> None:
    figure.set_size_inches(10, 7)
    axes = figure.subplots(2, 2, sharex=True)
    for column, (zero, found) in zip(axes.T, curves.items(), strict=True):
        for name, (f, L) in found.items():
            style = STYLES.get(name, "-" if name == "FBF best" else (0, (1, 2)))
            size = np.maximum(np.abs(L[1:]), 1e-3)
            column[0].semilogx(f[1:], 20 * np.log10(size), linestyle=style, label=name)
            phase = np.where(size > 0.1, np.degrees(np.unwrap(np.angle(L[1:]))), np.nan)  # of nothing, it says nothing
            column[1].semilogx(f[1:], phase, linestyle=style, label=name)
        column[0].axhspan(-20 * np.log10(MAGNITUDE), 20 * np.log10(MAGNITUDE), color="0.9", zorder=0)
        column[1].axhspan(-45, 45, color="0.9", zorder=0)
        column[0].set(title=f"a = {zero} ({SIDES[zero]})", ylabel="magnitude [dB]", ylim=(-20, 20))
        column[1].set(xlabel="frequency [Hz]", ylabel="phase [degrees]", xlim=(10, RATE / 2), ylim=(-270, 135))
    axes[0, 0].legend()


ITEMS = (
    Item(
        "duan-2015-table-2",
        "State space of the plant, and the rank test",
        PAPER,
        "Eq. 15, 21, 37-39",
        True,
        _state_space,
    ),
    Item("duan-2015-table-3", "Tracking errors, Figs. 4 and 5", PAPER, "Table 1, Eq. 10, 37", True, _tracking),
    Item("duan-2015-table-4", "Tracking bandwidths, Figs. 6 to 8", PAPER, "Table 1, Eq. 11, 37", True, _bandwidths),
)
