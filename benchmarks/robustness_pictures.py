"""Draw docs/robustness_corner.png and docs/robustness_spread.png: what a wrong model does, by method.

Files are compensated for the bed slinger's models, written, executed by the planner model, and drive other machines.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from executed import Executed, executed
from matplotlib.axes import Axes
from robustness import ROOT, UM, machine, printer_of

from fbfcli.pipeline import Settings
from fbfcli.printer import Printer

PART = ROOT / "sample_gcode" / "star.gcode"
CORNER_PICTURE, SPREAD_PICTURE = (ROOT / "docs" / f"robustness_{name}.png" for name in ("corner", "spread"))
PLANT, ACCELERATION = "35/28 Hz", 5000.0  # mm/s^2
OFF = 0.9  # of the model's frequencies: the machine of the first picture
CORNER = np.array([125.0, 150.0])  # a tip of the outer wall [mm]
LAYER_Z = 3.0  # mm
SPAN = 14.0  # mm of wall shown before and after the corner
LARGER = 30.0  # the error is drawn this many times larger
SHOWN = {"none": ("none", None, "#9aa0a6"), "MZV": ("mzv", None, "#d1495b"),
         "FBF": ("lpfbs", None, "#edae49"), "contour": ("contour", 0.15, "#00798c")}  # fmt: skip
FACTORS = np.linspace(0.8, 1.2, 17)
CURVES = {"ZV": ("zv", None, "#c9b6e4"), "MZV": ("mzv", None, "#d1495b"), "FBF": ("lpfbs", None, "#edae49"),
          "contour ±5 %": ("contour", 0.05, "#9bd1d9"), "contour ±10 %": ("contour", 0.10, "#4aa5b5"),
          "contour ±15 %": ("contour", 0.15, "#00798c"), "contour ±25 %": ("contour", 0.25, "#004651")}  # fmt: skip
DPI = 100
DT = Settings.dt  # s


def written(printer: Printer, method: str, spread: float | None) -> Executed:
    return executed(PART.read_bytes(), printer, Settings(method=method, acceleration=ACCELERATION, spread=spread))


def at_corner(print_: Executed) -> slice:
    """Samples of the outer wall's pass around the corner, half way up."""
    near = np.hypot(*(print_.desired - CORNER).T)
    layer = print_.extruding & (np.abs(print_.motion[:, 2] - LAYER_Z) < 1e-3)
    at = int(np.argmin(np.where(layer, near, np.inf)))
    along = np.cumsum(np.hypot(*np.diff(print_.desired, axis=0, prepend=print_.desired[:1]).T))
    return slice(*np.searchsorted(along, along[at] + np.array([-SPAN, SPAN])))


def offsets(path: np.ndarray, nozzle: np.ndarray) -> np.ndarray:
    """From the nearest of the path's points to each of the nozzle's, shape (n, 2) [mm]."""
    fine = np.column_stack([np.interp(np.arange(0, len(path) - 1, 0.05), np.arange(len(path)), x) for x in path.T])
    nearest = np.argmin(np.square(nozzle[:, None] - fine).sum(axis=2), axis=1)
    return nozzle - fine[nearest]


def corner(axes: Axes, printer: Printer, words: str, method: str, spread: float | None, colour: str) -> None:
    """One method's corner, its error drawn larger."""
    print_ = written(printer, method, spread)
    here = at_corner(print_)
    path, nozzle = print_.desired[here], print_.nozzle(machine(printer, OFF, 1.0, DT))[here]
    error = offsets(path, nozzle)
    axes.plot(*path.T, color="black", lw=1.0)
    axes.plot(*(nozzle + (LARGER - 1.0) * error).T, color=colour, lw=2.0)
    axes.set_aspect("equal")
    axes.set_title(f"{words}: {UM * np.sqrt(np.mean(np.square(error).sum(axis=1))):.0f} µm RMS", fontsize=11)
    axes.set_xlim(CORNER[0] - 6.5, CORNER[0] + 6.5)
    axes.set_ylim(CORNER[1] - SPAN, CORNER[1])
    axes.set_xticks([])
    axes.set_yticks([])


def draw_corner(file: Path) -> None:
    printer = printer_of(PLANT)
    figure, panels = plt.subplots(1, len(SHOWN), figsize=(12, 3.9))
    for axes, (words, how) in zip(panels, SHOWN.items(), strict=True):
        corner(axes, printer, words, *how)
    figure.suptitle(f"A star's tip where the machine's resonances are 10 % below the model's (error × {LARGER:.0f})")
    figure.tight_layout()
    figure.savefig(file, dpi=DPI)


def draw_spread(file: Path) -> None:
    printer = printer_of(PLANT)
    figure, axes = plt.subplots(figsize=(9, 5))
    for words, (method, spread, colour) in CURVES.items():
        print_ = written(printer, method, spread)
        error = [UM * print_.contour(print_.nozzle(machine(printer, q, 1.0, DT))) for q in FACTORS]
        axes.plot(100 * (FACTORS - 1), error, color=colour, label=words, lw=2 if method == "contour" else 1.4,
                  ls="-" if method == "contour" else "--")  # fmt: skip
    axes.set_xlabel("true resonances against the model's [%]")
    axes.set_ylabel("error across the path, RMS [µm]")
    axes.set_ylim(0, 60)
    axes.set_xlim(-20, 20)
    axes.legend(ncols=2)
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(file, dpi=DPI)


if __name__ == "__main__":
    draw_corner(CORNER_PICTURE)
    draw_spread(SPREAD_PICTURE)
