"""A picture of the worst corner, for people who will not open a page: where the nozzle should go, went, and goes."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify import palette
from fbfcli.verify.close_ups import CloseUp, Window
from fbfcli.verify.report_data import along
from fbfcli.verify.traces import Kept
from fbfcli.verify.wall import is_outer

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE_IN, DPI = (12.0, 6.0), 100
NEAREST_MM, FARTHEST_MM = 1.5, 8.0  # shown around a corner
REACH = 15.0  # errors shown around a corner
SEEN = 0.04  # of the picture: smaller errors are drawn larger
TIMES = (1, 2, 5, 10, 20, 50, 100)
SCALES_MM = (0.2, 0.5, 1.0, 2.0, 5.0)
STYLE: Any = {
    "font.size": 12, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": palette.GRID, "text.color": palette.INK, "axes.labelcolor": palette.INK,
    "axes.edgecolor": palette.FAINT, "xtick.color": palette.FAINT, "ytick.color": palette.FAINT,
}  # fmt: skip


def worst_seen(kept: Kept, features: tuple[str, ...]) -> CloseUp | None:
    """The first method's worst corner of an outer wall, which people look at; of anything where none is named so."""
    outer = {i for i, name in enumerate(features) if is_outer(name)}
    first = [corner for corner in kept.corners if corner.method == next(iter(kept.methods))]
    return next((corner for corner in first if corner.feature in outer), next(iter(first), None))


def before_after(kept: Kept, shown: CloseUp, title: str) -> Figure:
    """A corner: from above on the left, every method's errors on the right."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    colours = dict(zip(kept.methods, palette.METHODS * len(kept.methods), strict=False))
    windows = {name: window for name in kept.methods if (window := shown.windows.get(name)) is not None}
    with rc_context(STYLE):
        figure = Figure(figsize=SIZE_IN, dpi=DPI, layout="constrained")
        plan, plot = figure.subplots(1, 2, width_ratios=(1, 1.15))
        _plan(plan, shown, windows, colours)
        _errors(plot, shown, windows, colours)
        figure.suptitle(title, fontsize=13)
    return figure


def png(figure: Figure) -> bytes:
    """The figure as a file."""
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=DPI)
    return stream.getvalue()


def reach(corner: CloseUp) -> float:
    """How far the picture of a corner reaches to each side [mm]."""
    return float(np.clip(REACH * corner.error, NEAREST_MM, FARTHEST_MM))


def magnified(window: Window, times: float) -> np.ndarray:
    """The nozzle with its distance from the desired path drawn `times` larger, shape (n, 2) [mm]."""
    start, step = window.desired[:-1], np.diff(window.desired, axis=0)
    squared = np.maximum((step * step).sum(axis=1), np.finfo(float).tiny)
    away = window.nozzle[:, None] - start
    share = np.clip((away * step).sum(axis=2) / squared, 0.0, 1.0)
    gap = away - share[..., None] * step
    row = np.arange(len(window))
    return window.nozzle + (times - 1.0) * gap[row, np.argmin((gap * gap).sum(axis=2), axis=1)]


def _plan(axes: Axes, corner: CloseUp, windows: dict[str, Window], colours: dict[str, str]) -> None:
    """The path from above, and every nozzle."""
    far = reach(corner)
    times = next(t for t in TIMES if t * corner.error > SEEN * far or t == TIMES[-1])
    own = windows[corner.method]
    axes.plot(*own.desired.T, color=palette.DESIRED, linewidth=8, alpha=0.4, solid_joinstyle="miter",
              label="desired path")  # fmt: skip
    for name, window in windows.items():
        axes.plot(*magnified(window, times).T, color=colours[name], linewidth=1.8, label=f"nozzle, {name}")
    larger = f", errors drawn {times} times larger" if times > 1 else ""
    near = own.desired[np.abs(own.desired - np.array(corner.at)).max(axis=1) <= far]
    x, y = 0.5 * (near.min(axis=0) + near.max(axis=0))
    axes.set(xlabel="X [mm]", ylabel="Y [mm]", title=f"From above{larger}", aspect="equal",
             xlim=(x - far, x + far), ylim=(y - far, y + far))  # fmt: skip
    axes.locator_params(nbins=6)
    axes.legend(loc="best", frameon=True, framealpha=0.85, edgecolor="none")
    _scale_bar(axes, far)


def _scale_bar(axes: Axes, far: float) -> None:
    """A length to compare with, under the path."""
    long = max((each for each in SCALES_MM if each <= 0.5 * far), default=SCALES_MM[0])
    x, y = axes.get_xlim()[1] - 0.08 * far, axes.get_ylim()[0] + 0.1 * far
    axes.plot([x - long, x], [y, y], color=palette.INK, linewidth=2.5, solid_capstyle="butt")
    axes.annotate(f"{long:g} mm", (x - long / 2, y), xytext=(0, 4), textcoords="offset points", ha="center",
                  fontsize=10)  # fmt: skip


def _errors(axes: Axes, corner: CloseUp, windows: dict[str, Window], colours: dict[str, str]) -> None:
    """How far each nozzle is from the path, along it."""
    far = 2 * reach(corner)
    ends = along(windows[corner.method], corner.at)[[0, -1]]
    for name, window in windows.items():
        place = along(window, corner.at)
        near = np.abs(place) <= far
        rms = UM_PER_MM * float(np.sqrt(np.mean(window.error[near] ** 2)))
        axes.plot(place[near], UM_PER_MM * window.error[near], color=colours[name], linewidth=1.8,
                  label=f"{name}: {rms:.0f} µm RMS")  # fmt: skip
    axes.set(xlabel="along the path [mm]", ylabel="distance from the path, + is left [µm]", title="How far off",
             xlim=np.clip(ends, -far, far))  # fmt: skip
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.12 * (high - low))  # room for the legend
    axes.legend(loc="upper center", ncols=2, frameon=False, columnspacing=1.2, handlelength=1.4)
