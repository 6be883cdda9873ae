"""What is left of each method when the machine is not the one its profile describes.

    python benchmarks/robustness.py            the tables
    python benchmarks/robustness.py --write    puts them into docs/robustness.md

Each file is compensated for the profile's plant, written, executed by the planner model, and the result drives plants
whose frequencies or dampings are off. A print's number is the RMS of the contour error while extruding, of the worse
machine where a condition stands for two; a row is the geometric mean over parts and accelerations.
Why the worse of them, and parts of 20 to 25 mm at 100 mm/s: robustness_parts.py.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from executed import Executed, executed, rms
from page import options, put
from robustness_reference import REFERENCE

from fbfcli.cli.lookup import bundled
from fbfcli.control.limits import peaks
from fbfcli.pipeline import Settings
from fbfcli.plant.model import Plant, impulse_response
from fbfcli.plant.uncertainty import changed
from fbfcli.printer import ModalModel, Mode, Model, Printer
from fbfcli.verify.shaper_tuning import best

ROOT = Path(__file__).parents[1]
PAGE, COMMAND = ROOT / "docs" / "robustness.md", "benchmarks/robustness.py --write"
AGAINST = "against the reference"  # the page's second table, at its end
PARTS = ("ringing_tower", "star", "curve")
SLICED = ROOT / "sample_gcode" / "half_size"
LAYER, LAYERS = b";LAYER_CHANGE", 4
ACCELERATIONS = (5000.0, 15000.0)  # mm/s^2
TOLERANCE = 2e-3  # mm: with the default's 5e-3, what is measured at 70/56 Hz is a third the chords'
COMMAND_ACCELERATION, COMMAND_VELOCITY = 1e5, 600.0  # wide: what a method asks for is reported, not cut
SHAPERS = ("zv", "mzv", "ei")
METHODS = ("none", *SHAPERS, "lpfbs", "robust", "contour")
LAG_ALONE = "lag alone"  # a nozzle exactly on its path, but each axis as much later as the condition makes it
SUITED = ("taz6 x/hictop x",)  # several damped modes: a shaper is made for the frequency that suits it best
LAGGING = ("none", *SHAPERS)  # do not know that one axis may lag behind the other: here they are told, by the model
SPREADS = (0.15, 0.10)
SPREADS_OF: dict[str, tuple[float | None, ...]] = {"robust": SPREADS[:1], "contour": SPREADS}
UM = 1e3
NOTHING = 1e-9  # um: an error of zero has no logarithm


def one(f: float) -> ModalModel:
    return ModalModel((Mode(f, 0.05),))


def two(f: float, g: float) -> ModalModel:
    return ModalModel((Mode(f, 0.05, 0.7), Mode(g, 0.05, 0.3)))


def measured(name: str) -> Model:
    model = bundled()[name].axes[0].model
    assert model is not None
    return model


PLANTS: dict[str, Callable[[], tuple[Model, Model]]] = {
    "35/28 Hz": lambda: (one(35.0), one(28.0)),
    "45/36 Hz": lambda: (one(45.0), one(36.0)),
    "45+85/38+66 Hz": lambda: (two(45.0, 85.0), two(38.0, 66.0)),
    "taz6 x/hictop x": lambda: (measured("taz6"), measured("hictop_prusa_i3")),
    "70/56 Hz": lambda: (one(70.0), one(56.0)),
}
# how the machine differs from its model: factors on frequency and damping; an error is the worst of the machines'
CONDITIONS: dict[str, tuple[tuple[float, float], ...]] = {
    "exact": ((1.0, 1.0),),
    "±5 %": ((0.95, 1.0), (1.05, 1.0)),
    "±10 %": ((0.9, 1.0), (1.1, 1.0)),
    "±15 %": ((0.85, 1.0), (1.15, 1.0)),
    "ζ × ½": ((1.0, 0.5),),
    "ζ × 2": ((1.0, 2.0),),
}


@dataclass(frozen=True)
class Case:
    """One print by one method; figures [um] by condition.

    across, along : RMS error normal to the path while extruding, and along it, of each machine of a condition
    peak, speed   : largest commanded |u''| and |u'| of an axis, as multiples of the desired motion's
    ripple        : of a bead's width by condition, with E on the plan's time and with the nozzle; contour only
    """

    plant: str
    part: str
    acceleration: float
    method: str
    across: dict[str, tuple[float, ...]]
    along: dict[str, tuple[float, ...]]
    peak: float
    speed: float
    ripple: dict[str, tuple[float, float]]


def called(method: str, spread: float | None) -> str:
    """A method in the tables."""
    return method if spread is None else f"{method} ±{100 * spread:.0f} %"


def printer_of(plant: str) -> Printer:
    """A Klipper machine with these models."""
    base = bundled()["synthetic_bed_slinger"]
    x, y, z = base.axes
    wide = {"command_acceleration": COMMAND_ACCELERATION, "command_velocity": COMMAND_VELOCITY}
    model_x, model_y = PLANTS[plant]()
    return replace(base, axes=(replace(x, model=model_x, **wide), replace(y, model=model_y, **wide), z))


def machines(printer: Printer, condition: str, dt: float) -> Iterator[tuple[Plant, ...]]:
    """The plants that a condition stands for."""
    for q, d in CONDITIONS[condition]:
        yield machine(printer, q, d, dt)


def machine(printer: Printer, q: float, d: float, dt: float) -> tuple[Plant, ...]:
    """The plants whose frequencies are q times, and dampings d times, the models'."""
    return tuple(changed(axis.model, q, d, dt, axis.name) for axis in printer.axes[:2] if axis.model)


def layers(text: bytes) -> bytes:
    """Every fourth layer of a PrusaSlicer file with relative E: all kinds of lines, in a quarter of the time."""
    head, *pieces = text.split(LAYER)
    return LAYER.join([head, *pieces[:-1:LAYERS], pieces[-1]])


def lags(plants: Iterable[Plant]) -> tuple[float, ...]:
    """How late each axis follows a slow command, sum k h_k [samples]."""
    return tuple(float(np.arange(len(h)) @ h) for h in map(impulse_response, plants))


def case(plant: str, part: str, text: bytes, acceleration: float, method: str, spread: float | None,
         beads_told: bool = False) -> Case:  # fmt: skip
    """Compensate, write, execute, and drive every machine."""
    printer = printer_of(plant)
    lagging = method in (*LAGGING, LAG_ALONE)
    settings = Settings(method="none" if method == LAG_ALONE else method, acceleration=acceleration,
                        tolerance=TOLERANCE, spread=spread)  # fmt: skip
    exact = next(machines(printer, "exact", settings.dt))
    if method in SHAPERS and plant in SUITED:
        settings = replace(settings, shaped=suited(method, exact))
    done = executed(text, printer, settings)
    on_plan = executed(text, printer, replace(settings, with_nozzle=False)) if beads_told else None
    across: dict[str, tuple[float, ...]] = {}
    along: dict[str, tuple[float, ...]] = {}
    ripple: dict[str, tuple[float, float]] = {}
    ahead = lags(exact) if lagging else (0.0, 0.0)
    for condition in CONDITIONS:
        put_by = late if method == LAG_ALONE else Executed.nozzle
        nozzles = [put_by(done, plants, ahead) for plants in machines(printer, condition, settings.dt)]
        across[condition] = tuple(UM * done.contour(nozzle) for nozzle in nozzles)
        along[condition] = tuple(UM * done.along(nozzle) for nozzle in nozzles)
        if on_plan:
            before, after = (max(each.ripple(n, on_plan) for n in nozzles) for each in (on_plan, done))
            ripple[condition] = before, after
    return Case(plant, part, acceleration, called(method, spread), across, along, *_asked(done, settings.dt), ripple)


def suited(shaper: str, plants: tuple[Plant, ...]) -> tuple[float, float]:
    """Frequencies of X and Y that leave the shaper least of a corner's error [Hz]."""
    x, y = (best(shaper, plant) for plant in plants)
    assert x is not None and y is not None  # both vibrate
    return x.frequency, y.frequency


def late(done: Executed, plants: tuple[Plant, ...], ahead: tuple[float, ...]) -> np.ndarray:
    """The path, each axis late by what it lags more than `ahead`, shape (n, 2) [mm]."""
    k = np.arange(len(done.desired))
    more = [lag - known for lag, known in zip(lags(plants), ahead, strict=True)]
    return np.column_stack([np.interp(k - lag, k, y) for lag, y in zip(more, done.desired.T, strict=True)])


def _asked(done: Executed, dt: float) -> tuple[float, float]:
    """Largest commanded acceleration and speed over the desired motion's."""
    (v, a), (v_d, a_d) = (peaks(x, done.begin, dt) for x in (done.command, done.desired))
    return float(a.max() / a_d.max()), float(v.max() / v_d.max())


def cases(say: Callable[[str], object]) -> list[Case]:
    """Every print by every method."""
    found = []
    for plant in PLANTS:
        for part in PARTS:
            started = time.process_time()
            text = layers((SLICED / f"{part}.gcode").read_bytes())
            for acceleration in ACCELERATIONS:
                for method in (*METHODS, LAG_ALONE):
                    for spread in SPREADS_OF.get(method, (None,)):
                        beads_told = method == "contour" and spread == SPREADS[0]
                        found.append(case(plant, part, text, acceleration, method, spread, beads_told))
            say(f"{plant}, {part}: {time.process_time() - started:.1f} s of CPU\n")
    return found


def geometric(values: Iterable[float]) -> float:
    return float(np.exp(np.mean(np.log(np.maximum(list(values), NOTHING)))))


def mean(found: list[Case], plant: str, method: str, condition: str, what: str = "across",
         of: Callable[[tuple[float, ...]], float] = max) -> float:  # fmt: skip
    """Geometric mean over parts and accelerations; `of` a condition's machines, their worst."""
    return geometric(of(getattr(c, what)[condition]) for c in found if (c.plant, c.method) == (plant, method))


def table(found: list[Case], what: str) -> str:
    """A row for each plant and method."""
    lines = ["| x/y | method | " + " | ".join(CONDITIONS) + " |", "|---" * (2 + len(CONDITIONS)) + "|"]
    for plant in PLANTS:
        for method in dict.fromkeys(c.method for c in found):
            cells = [f"{mean(found, plant, method, condition, what):.1f}" for condition in CONDITIONS]
            name = f"**{method}**" if method.startswith("contour") else method
            lines.append(f"| {plant} | {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def compared(found: list[Case]) -> str:
    """Ratios to the reference, where it has a number."""
    lines = ["| x/y | method | " + " | ".join(CONDITIONS) + " |", "|---" * (2 + len(CONDITIONS)) + "|"]
    for plant, rows in REFERENCE.items():
        for method, numbers in rows.items():
            cells = []
            for condition, number in zip(CONDITIONS, numbers, strict=True):
                cell = f"{mean(found, plant, method, condition) / number:.2f}"
                if len(CONDITIONS[condition]) > 1:
                    of_both = mean(found, plant, method, condition, of=lambda pair: rms(np.array(pair)))
                    cell += f" ({of_both / number:.2f})"
                cells.append(cell)
            name = f"**{method}**" if method.startswith("contour") else method
            lines.append(f"| {plant} | {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def behind(found: list[Case], method: str) -> str:
    """How often a method is ahead of the best shaper, and the cells where it is not."""
    at = {(c.plant, c.part, c.acceleration, c.method): c.across for c in found}
    lines = []
    for condition in CONDITIONS:
        lost = []
        places = [(plant, part, a) for plant in PLANTS for part in PARTS for a in ACCELERATIONS]
        for place in places:
            own = max(at[(*place, method)][condition])
            least, shaper = min((max(at[(*place, name)][condition]), name) for name in SHAPERS)
            if own >= least:
                plant, part, a = place
                lost.append(f"{plant} {part} {a:.0f}: {own:.1f} against {shaper} {least:.1f}")
        lines.append(f"- {condition}: ahead in {len(places) - len(lost)} of {len(places)}"
                     + (f"; not in {'; '.join(lost)}" if lost else ""))  # fmt: skip
    return "\n".join(lines)


def asked(found: list[Case]) -> str:
    """Commanded peaks by plant and method."""
    lines = ["| x/y | method | peak acceleration | peak speed |", "|---|---|---|---|"]
    for plant in PLANTS:
        for method in dict.fromkeys(c.method for c in found if c.method != LAG_ALONE):
            own = [c for c in found if (c.plant, c.method) == (plant, method)]
            a, v = ([getattr(c, name) for c in own] for name in ("peak", "speed"))
            lines.append(f"| {plant} | {method} | {min(a):.2f} to {max(a):.2f} | {min(v):.2f} to {max(v):.2f} |")
    return "\n".join(lines)


def beads(found: list[Case]) -> str:
    """Ripple of the bead's width, per cent: E on the plan's time -> E with the nozzle."""
    method = called("contour", SPREADS[0])
    lines = ["| x/y | " + " | ".join(CONDITIONS) + " |", "|---" * (1 + len(CONDITIONS)) + "|"]
    for plant in PLANTS:
        own = [c for c in found if (c.plant, c.method) == (plant, method)]
        cells = (" -> ".join(f"{100 * geometric(c.ripple[condition][i] for c in own):.1f}" for i in (0, 1))
                 for condition in CONDITIONS)  # fmt: skip
        lines.append(f"| {plant} | {' | '.join(cells)} |")
    return "\n".join(lines)


def report(found: list[Case]) -> str:
    """All tables of this program alone."""
    wide = called("contour", SPREADS[0])
    return "\n\n".join([
        "### Error across the path", table(found, "across"),
        f"Cell by cell (plant, part, acceleration), `{wide}` against the best of {', '.join(SHAPERS)}:",
        behind(found, wide),
        "### Error along the path", table(found, "along"),
        "### What is commanded, as multiples of the desired motion's own peaks", asked(found),
        "### Ripple of the bead's width: E on the plan's time → E with the nozzle [%]", beads(found),
    ])  # fmt: skip


def main() -> None:
    wanted = options(__doc__, PAGE).parse_args()
    found = cases(sys.stderr.write)
    print(report(found), compared(found), sep="\n\n### Ratio to the reference\n\n")
    if wanted.write:
        put(PAGE, COMMAND, report(found))
        put(PAGE, f"{COMMAND}, {AGAINST}", compared(found))


if __name__ == "__main__":
    main()
