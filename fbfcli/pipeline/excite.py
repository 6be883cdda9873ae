"""A sweep for one axis of a printer: laid out within its limits, written, and executed by the planner's model."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import isfinite

import numpy as np

from fbfcli import __version__
from fbfcli.errors import LimitError
from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.scan import scan
from fbfcli.gcode.sweep_file import SweepFile, sweep_file
from fbfcli.motion.budget import MARLIN_STEPS
from fbfcli.motion.moves import moves_xy
from fbfcli.motion.planner import Planner
from fbfcli.motion.travel import check_travel
from fbfcli.plant.square_sweep import SweepSettings, Swings, frequencies_of, swings
from fbfcli.plant.sweep_spec import SWEPT, sweep_csv
from fbfcli.printer import Limits, Printer

DEFAULT_ACCELERATIONS = (2000.0, 3500.0, 5000.0)  # Ramani et al. 2020b, Fig. 4: 2 to 5 m/s^2
STEPS = 2  # elsewhere: less is no square wave any more
ROOM = 0.8  # of the travel that a sweep may take
BUSY = 0.9  # of the segments that the firmware takes per second
OFF = 0.1  # of a swing's duration that the planner's answer may be off, rms: more is another test
NO_PHASE = 1e-6  # s: shorter phases are rounding
FASTEST = 300.0  # mm/s where the profile does not say


@dataclass(frozen=True)
class Excited:
    """What `excite` made: files, and words about them.

    gcode   : the file for the printer
    command : its acceleration as CSV, as the planner's model executes the file
    summary : figures for --json
    """

    gcode: bytes
    command: str
    summary: ExciteSummary


@dataclass(frozen=True)
class ExciteSummary:
    """Figures of a sweep. duration [s], frequencies [Hz], accelerations [mm/s^2], speed [mm/s], reach [mm]."""

    printer: str
    axis: str
    duration: float
    moves: int
    sweeps: tuple[tuple[float, float, float], ...]  # acceleration, first and last frequency
    speed: float
    reach: float
    off: float  # rms, of a swing's duration: planner's answer against what was asked for
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        return asdict(self)

    def text(self) -> str:
        """For people, on stderr."""
        rows = [f"{a:g} mm/s2 from {f0:.1f} to {f1:.1f} Hz" for a, f0, f1 in self.sweeps]
        return "\n".join([
            f"axis:     {self.axis} of {self.printer}",
            f"sweeps:   {'; '.join(rows)}",
            f"motion:   {self.duration:.0f} s, {self.moves} moves, {self.reach:.1f} mm around the middle, "
            f"{self.speed:.0f} mm/s at most",
            f"planner:  its swings last as long as they should to {100 * self.off:.2f} % rms; the CSV has its times",
            *(f"note:     {note}" for note in self.notes),
        ])  # fmt: skip


def excite(printer: Printer, axis: str, f0: float, f1: float, rate: float, accelerations: tuple[float, ...]) -> Excited:
    """A sweep of `axis` ('x', 'y') from f0 to f1 [Hz], rising by `rate` [Hz/s], for each acceleration [mm/s^2].

    No accelerations: those of DEFAULT_ACCELERATIONS that the printer allows. Raises LimitError where it allows none.
    """
    index = "xy".index(axis)
    settings, notes = _within(printer, index, f0, f1, rate, accelerations)
    plan = swings(settings)
    low, high = printer.axes[index].travel
    way = np.concatenate([[0.0], np.cumsum(plan.distance)])
    start = 0.5 * (low + high) - 0.5 * (way.max() + way.min())
    if np.ptp(way) > ROOM * (high - low):
        raise LimitError(f"the sweep needs {np.ptp(way):.0f} mm of {axis.upper()}, whose travel is {high - low:g} mm; "
                         "start at a higher --from")  # fmt: skip
    about = [f"fbf {__version__} excite: sweeps of {axis.upper()} for {printer.name}",
             "homes, goes to the middle and shakes: clear the bed, and keep a hand at the switch"]  # fmt: skip
    file = sweep_file(printer, index, plan, float(start), about)
    edge, a, v, begins = executed(file, printer, index)
    off = _off(plan, begins)
    if off > OFF:
        raise LimitError(f"the planner of {printer.name} would be {100 * off:.0f} % off this sweep; "
                         "lower --accel or --to")  # fmt: skip
    told = []
    for number, size in enumerate(settings.accelerations, 1):
        inside = np.flatnonzero(plan.part == number)
        told.append(SWEPT.format(size, *frequencies_of(settings, size), begins[inside[0]], begins[inside[-1] + 1]))
    made = ExciteSummary(printer.name, axis, float(edge[-1]), len(plan),
                         tuple((size, *frequencies_of(settings, size)) for size in settings.accelerations),
                         float(v.max()), float(0.5 * np.ptp(way)), off, tuple(notes))  # fmt: skip
    return Excited(file.text, sweep_csv(edge, a, axis, [about[0], *told]), made)


def executed(file: SweepFile, printer: Printer, axis: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What the planner's model makes of the swings of a file.

    Returns when the acceleration changes [s] and to what [mm/s^2], both shape (m,), the peak speed of each swing, and
    when each swing begins and the last one ends, shape (n + 1,) [s].
    """
    block, _ = interpret(scan(file.text), initial_state(printer), printer)
    check_travel(block.moves, block.known[block.moves.line], tuple(one.travel for one in printer.axes))
    parts = list(Planner(printer.firmware).feed(block.moves, np.zeros(len(block.moves), dtype=bool), last=True))
    line = np.concatenate([part.moves.line for part in parts])
    swing = np.concatenate([moves_xy(part.moves) for part in parts]) & (line >= file.first) & (line < file.last)

    def of(name: str) -> np.ndarray:
        return np.concatenate([getattr(part.profile, name) for part in parts])[swing]

    sign = np.sign(np.concatenate([part.moves.delta[:, axis] for part in parts])[swing])
    length = np.column_stack([of("t_accel"), of("t_cruise"), of("t_decel")])
    a = np.column_stack([sign * of("accel"), np.zeros(len(sign)), -sign * of("accel")])
    begins = np.concatenate([[0.0], np.cumsum(length.sum(axis=1))])
    real = length.ravel() > NO_PHASE
    edge = np.concatenate([[0.0], np.cumsum(length.ravel())])
    return np.append(edge[:-1][real], edge[-1]), np.append(a.ravel()[real], 0.0), of("v_cruise"), begins


def _within(printer: Printer, axis: int, f0: float, f1: float, rate: float, accelerations: tuple[float, ...]
            ) -> tuple[SweepSettings, list[str]]:  # fmt: skip
    """The settings as far as the printer allows them, and what had to be left out."""
    one, notes = printer.axes[axis], []
    ceiling = min(printer.limits.axis_acceleration[axis], one.command_acceleration)
    mild = min(ceiling, printer.limits.acceleration)
    if accelerations:
        over = [a for a in accelerations if a > ceiling]
        if over:
            raise LimitError(f"--accel {over[0]:g}: the profile of {printer.name} allows {ceiling:g} mm/s^2")
        chosen = tuple(sorted(set(accelerations)))
    else:
        chosen = tuple(sorted({min(a, mild) for a in DEFAULT_ACCELERATIONS}))
        if len(chosen) < len(DEFAULT_ACCELERATIONS):
            notes.append(f"the printer's acceleration is {mild:g} mm/s2: harder sweeps are left out (--accel)")
    v = min(_fastest(printer.limits, axis), one.command_velocity)
    steps = MARLIN_STEPS if printer.firmware == "marlin" else STEPS
    settings = SweepSettings(f0, min(f1, 0.5 * BUSY * printer.segments_per_second), rate, chosen,
                             v if isfinite(v) else FASTEST, steps / one.steps_per_mm)  # fmt: skip
    if settings.f1 < f1:
        notes.append(f"the firmware takes {printer.segments_per_second:g} moves a second: to {settings.f1:.0f} Hz only")
    for a in chosen:
        first, last = frequencies_of(settings, a)
        if last < 2 * first:
            raise LimitError(f"at {a:g} mm/s^2 only {first:.1f} to {last:.1f} Hz can be swept; give another --accel")
        if last < settings.f1:
            notes.append(f"at {a:g} mm/s2 swings above {last:.0f} Hz are shorter than {steps} steps")
        if first > f0:
            notes.append(f"at {a:g} mm/s2 swings below {first:.1f} Hz are faster than {settings.velocity:g} mm/s")
    return settings, notes


def _fastest(limits: Limits, axis: int) -> float:
    return min(limits.velocity, limits.axis_velocity[axis])


def _off(plan: Swings, begins: np.ndarray) -> float:
    """rms by which swings last longer or shorter than asked for, of their duration."""
    wanted = 2 * np.sqrt(np.abs(plan.distance) / plan.acceleration)
    swing = plan.part > 0
    return float(np.sqrt(np.mean((np.diff(begins)[swing] / wanted[swing] - 1) ** 2)))
