"""Ramani 2018, Table 1, by simulation: print time and contour error by acceleration, without and with LPFBS."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fbfcli.errors import GcodeError
from fbfcli.gcode.scan import chunks
from fbfcli.papers.item import Item, Progress, Result, judged, not_reproducible
from fbfcli.pipeline.compensate import compensate
from fbfcli.pipeline.settings import Settings
from fbfcli.printer import Printer

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "ramani-2018-table-1"
ACCELERATIONS = (1, 3, 5, 7, 10)  # m/s^2; the printed 30 m/s^2 has no baseline
PRINTED = {1: "3:59 h", 3: "2:41 h", 5: "2:21 h", 7: "2:12 h", 10: "2:06 h"}
FEED = 60.0  # mm/s, of the paper
MM_PER_M = 1e3


@dataclass(frozen=True)
class Print:
    """One print of the part.

    time          : float   s
    before, after : float   RMS contour error without and with compensation, while extruding [um]
    """

    time: float
    before: float
    after: float


def study(part: bytes, printer: Printer, progress: Progress) -> dict[int, tuple[Print, Print]]:
    """The part printed uncompensated and by LPFBS, by acceleration [m/s^2]."""
    found = {}
    for k, a in enumerate(ACCELERATIONS):
        settings = (Settings(method=m, acceleration=a * MM_PER_M, velocity=FEED) for m in ("none", "lpfbs"))
        plain, compensated = (_printed(part, printer, each) for each in settings)
        if plain.after == 0.0:
            raise GcodeError("no extruding move of this part can be compensated", remedy="take a sliced print")
        found[a] = plain, compensated
        progress((k + 1) / len(ACCELERATIONS))
    return found


def _printed(part: bytes, printer: Printer, settings: Settings) -> Print:
    summary = compensate(chunks(io.BytesIO(part)), printer, settings, lambda text: None).summary
    return Print(summary.time, summary.contour_before.rms, summary.contour_after.rms)


def item(part: Callable[[], bytes], printer: Callable[[], Printer]) -> Item:
    """The table, of the part and the printer that the callables read when it is computed."""

    def compute(seeds: int, progress: Progress) -> Result:
        return _table(study(part(), printer(), progress))

    return Item(NAME, "Print time and contour error by acceleration", "Ramani 2018", "Table 1", False, compute)


def _table(found: dict[int, tuple[Print, Print]]) -> Result:
    why = "the model of the US Capitol is not published, and its quality is shown as photographs"
    rows = []
    for a, (plain, compensated) in found.items():
        times = f"{plain.time:.0f} s, {compensated.time:.0f} s"
        errors = f"{plain.after:.1f}, {compensated.after:.1f}"
        rows.append(not_reproducible(f"{a} m/s^2: print time without, with LPFBS", PRINTED[a], why, times))
        rows.append(not_reproducible(f"{a} m/s^2: RMS contour error without, with [um]", "photograph", why, errors))
    low, high = found[ACCELERATIONS[0]], found[ACCELERATIONS[-1]]
    faster = [with_.time for _, with_ in found.values()]
    rougher = [plain.after for plain, _ in found.values()]
    rows += [
        judged(faster == sorted(faster, reverse=True), "print time with LPFBS, 1 to 10 m/s^2", "falls",
               f"{1 - faster[-1] / faster[0]:.0%} shorter", "ordering", "47 % on the paper's part"),
        judged(rougher == sorted(rougher), "contour error without compensation, 1 to 10 m/s^2", "grows",
               f"{rougher[-1] / rougher[0]:.2f} times", "ordering"),
        judged(all(c.after < p.after / 4 for p, c in found.values()), "contour error with LPFBS, every acceleration",
               "no visible distortion", f"at most {max(c.after / p.after for p, c in found.values()):.0%}",
               "under a quarter of that without"),
        judged(high[1].after < low[0].after, "contour error with LPFBS at 10 m/s^2 over that without at 1 m/s^2",
               "no loss of quality", high[1].after / low[0].after, "< 1"),
    ]  # fmt: skip
    caption = (
        "Print time and predicted RMS contour error of a part at 60 mm/s on the printed model of a HICTOP Prusa i3 "
        "(Ramani 2018 Eq. 7; y as x), by acceleration, as planned and by LPFBS (Ramani 2020b Eq. 23, 24). Simulated: "
        "Table 1 of Ramani 2018 is printed on the machine."
    )
    return Result(tuple(rows), lambda figure: _draw(figure, found), caption)


def _draw(figure: Figure, found: dict[int, tuple[Print, Print]]) -> None:
    error, time = figure.subplots(1, 2)
    for k, (name, style) in enumerate((("without compensation", "o--"), ("LPFBS", "s-"))):
        error.plot(ACCELERATIONS, [both[k].after for both in found.values()], style, label=name)
        time.plot(ACCELERATIONS, [both[k].time for both in found.values()], style, label=name)
    error.set(xlabel="acceleration [m/s$^2$]", ylabel="RMS contour error [µm]", ylim=(0, None))
    time.set(xlabel="acceleration [m/s$^2$]", ylabel="print time [s]", ylim=(0, None))
    error.legend()
