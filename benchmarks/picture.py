"""Draw docs/before_after.png: a corner of the ringing tower, printed as sliced and as compensated.

Both are the planner's answer to a file's text, driven through the printer's models.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from trajectory import Motion, motion

from fbfcli.cli.lookup import bundled
from fbfcli.gcode.scan import chunks
from fbfcli.pipeline import Settings, compensate
from fbfcli.printer import Printer

ROOT = Path(__file__).parents[1]
PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
PICTURE = ROOT / "docs" / "before_after.png"
PRINTER = "synthetic_bed_slinger"
ACCELERATION = 5000.0  # mm/s^2
LAYER_Z = 3.0  # mm
CORNER = np.array([145.0, 145.0])  # of the outer wall [mm]
SPAN = 14.0  # mm of wall shown before and after the corner
SPARE = 2.0  # mm of path that is known beyond: the nozzle may be ahead or behind
UM = 1e3
DPI = 100
GREY, RED, BLUE = "#9aa0a6", "#d1495b", "#00798c"


@dataclass(frozen=True)
class Seen:
    """One pass of the nozzle around the corner.

    path   : ndarray, shape (m, 2)   where it should go, and SPARE more at both ends [mm]
    nozzle : ndarray, shape (n, 2)   where it goes [mm]
    """

    path: np.ndarray
    nozzle: np.ndarray


def seen(moved: Motion, nozzle: np.ndarray) -> Seen:
    """The extruding pass nearest the corner in the layer."""
    layer = moved.extruding & (np.abs(moved.desired[:, 2] - LAYER_Z) < 1e-3)
    away = np.where(layer, np.hypot(*(moved.desired[:, :2] - CORNER).T), np.inf)
    at = int(np.argmin(away))
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(moved.desired[:, :2], axis=0).T))])
    along = travelled - travelled[at]
    known, shown = (slice(*np.searchsorted(along, [-span, span])) for span in (SPAN + SPARE, SPAN))
    return Seen(moved.desired[known, :2], nozzle[shown])


def errors(nozzle: np.ndarray, path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place along the path and signed distance from it of each point of the nozzle [mm], shape (n,) each."""
    start, step = path[:-1], np.diff(path, axis=0)
    length = np.hypot(*step.T)
    start, step, length = start[length > 0], step[length > 0], length[length > 0]
    away = nozzle[:, None] - start
    share = np.clip((away * step).sum(axis=2) / length**2, 0.0, 1.0)
    gap = away - share[..., None] * step
    nearest = np.argmin((gap * gap).sum(axis=2), axis=1)
    row = np.arange(len(nozzle))
    side = step[nearest, 0] * away[row, nearest, 1] - step[nearest, 1] * away[row, nearest, 0]
    place = (np.cumsum(length) - length)[nearest] + share[row, nearest] * length[nearest]
    return place, np.copysign(np.hypot(*gap[row, nearest].T), side)


def passes(printer: Printer) -> tuple[Seen, Seen]:
    """The corner as sliced, and as compensated: both files as their planner executes them."""
    text, written = PART.read_bytes(), io.BytesIO()
    compensate(chunks(io.BytesIO(text)), printer, Settings(method="lpfbs", acceleration=ACCELERATION), written.write)
    as_sliced = Settings(method="none", acceleration=ACCELERATION)
    as_written = Settings(method="none")
    before, after = motion(text, printer, as_sliced), motion(written.getvalue(), printer, as_written)
    return (seen(before, before.nozzle(printer, as_sliced)), seen(after, after.nozzle(printer, as_written)))


def draw(before: Seen, after: Seen) -> plt.Figure:
    """Plan view on the left, errors along the path on the right."""
    figure, (plan, plot) = plt.subplots(1, 2, figsize=(12, 6), dpi=DPI, width_ratios=(1, 1.15), layout="constrained")
    draw_plan(plan, before, after)
    draw_errors(plot, before, after)
    return figure


def draw_plan(axes: Axes, before: Seen, after: Seen) -> None:
    """The path from above, and both nozzles."""
    axes.plot(*before.path.T, color=GREY, linewidth=7, alpha=0.45, solid_joinstyle="miter", label="desired path")
    axes.plot(*before.nozzle.T, color=RED, linewidth=1.8, label="nozzle, as sliced")
    axes.plot(*after.nozzle.T, color=BLUE, linewidth=1.8, label="nozzle, compensated")
    axes.set(xlabel="X [mm]", ylabel="Y [mm]", title=f"Corner of a tower at 200 mm/s, {ACCELERATION:.0f} mm/s²")
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=6)
    axes.legend(loc="lower left", frameon=False)


def draw_errors(axes: Axes, before: Seen, after: Seen) -> None:
    """How far both nozzles are from the path, along it."""
    for one, colour, name in ((before, RED, "as sliced"), (after, BLUE, "compensated")):
        place, error = errors(one.nozzle, before.path)
        rms = UM * float(np.sqrt(np.mean(error**2)))
        axes.plot(place - SPAN - SPARE, UM * error, color=colour, linewidth=1.8, label=f"{name}: {rms:.0f} µm RMS")
    axes.set(xlabel="along the path, from the corner [mm]", ylabel="distance from the path, + is left [µm]",
             title="Contour error, predicted", xlim=(-SPAN, SPAN))  # fmt: skip
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.12 * (high - low))  # room for the legend
    axes.legend(loc="upper center", ncols=2, frameon=False, columnspacing=1.2, handlelength=1.4)


def main() -> None:
    plt.rcParams.update({"font.size": 12, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
                         "grid.color": "#dfe2e6", "axes.axisbelow": True})  # fmt: skip
    draw(*passes(bundled()[PRINTER])).savefig(PICTURE)


if __name__ == "__main__":
    main()
