"""A simulation as a report tells it: names for people, figures that are read first, tables, and limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fbfcli.pipeline import report_sheets as sheets
from fbfcli.pipeline.designs import Designs, box_of
from fbfcli.pipeline.settings import AS_WRITTEN, AUTO, Settings
from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.summary import clock
from fbfcli.plant.model import modes
from fbfcli.printer import Printer
from fbfcli.units import UM_PER_MM
from fbfcli.verify.account import Three
from fbfcli.verify.figures import before_after, png, worst_seen
from fbfcli.verify.report import html
from fbfcli.verify.subject import Card, Ceilings, Face, Sheet, Spans, Subject
from fbfcli.verify.traces import Kept

AS_SLICED = "as sliced"


def labels(simulation: Simulation) -> dict[str, str]:
    """What people call the methods that were asked for: `none` changes nothing, `auto` is the method that was taken."""
    called = {one.name: AS_SLICED if one.name == AS_WRITTEN else one.name for one in shown(simulation)}
    taken = {one.name: one.method for one in shown(simulation) if one.name == AUTO and one.method not in called}
    return called | taken


def shown(simulation: Simulation) -> Sequence[Simulated]:
    """The results that the pictures show: those with the first acceleration."""
    return [one for one in simulation.results if one.acceleration == simulation.results[0].acceleration]


def page(file: str, kept: Kept, simulation: Simulation, printer: Printer, machine: Printer, settings: Settings) -> str:
    """The report of what was kept of a simulation, HTML.

    printer, machine : that the text is meant for, and that draws it
    """
    return html(kept.renamed(labels(simulation)), subject(file, simulation, printer, machine, settings))


def picture(file: str, kept: Kept, simulation: Simulation) -> bytes | None:
    """The worst corner before and after, a PNG; None where nothing moves."""
    renamed = kept.renamed(labels(simulation))
    corner = worst_seen(renamed, simulation.features)
    if corner is None:
        return None
    feature = simulation.features[corner.feature]
    title = f"{file} on {simulation.machine}, predicted: {feature}, layer {corner.layer + 1}, line {corner.line + 1}"
    return png(before_after(renamed, corner, title))


def subject(file: str, simulation: Simulation, printer: Printer, machine: Printer, settings: Settings) -> Subject:
    """Everything on the page that is not a picture."""
    called = labels(simulation)
    named = [(called[one.name], one) for one in shown(simulation)]
    designs, box = Designs(machine, AS_WRITTEN, Settings(dt=1.0 / simulation.rate)), box_of(printer)
    return Subject(
        title=f"{file}: where the nozzle goes",
        lead=_lead(named, printer, machine),
        warnings=simulation.warnings,
        cards=_cards(named),
        sheets=_sheets(simulation, named, called),
        by_layer={name: _spans(one.figures[0].by_layer, _most(named, "by_layer")) for name, one in named},
        by_feature={name: _spans(one.figures[0].by_feature, len(simulation.features)) for name, one in named},
        faces=_faces(named, simulation.features),
        features=tuple(simulation.features),
        plants=designs.b_a(0),
        dt=1.0 / simulation.rate,
        ceilings=Ceilings(
            (float(box.velocity[0]), float(box.velocity[1])),
            (float(box.acceleration[0]), float(box.acceleration[1])),
            settings.segments_per_second or printer.segments_per_second,
        ),
        settings=(*_settings(simulation, named, settings, printer, machine), ("its modes", _modes(designs))),
    )


def _lead(named: sheets.Named, printer: Printer, machine: Printer) -> str:
    whose = printer.name if machine is printer else f"{machine.name} with text meant for {printer.name}"
    methods = ", ".join(name for name, _ in named)
    return (
        f"Predicted for {whose}: {methods}. The planner's answer to the file is executed, the machine's vibration "
        "model is driven with it. Nothing here was measured on a printer."
    )


def _cards(named: sheets.Named) -> tuple[Card, ...]:
    """The best method against the first."""
    (first, before), (name, after) = named[0], min(named, key=lambda each: each[1].figures[0].drawn.contour.rms)
    was, now = (one.figures[0].drawn.contour for one in (before, after))
    figures = (
        ("off the path, RMS", f"{now.rms:.1f} µm", f"{was.rms:.1f} µm"),
        ("99 % of the print within", f"{now.p99:.0f} µm", f"{was.p99:.0f} µm"),
        ("largest error", f"{now.max:.0f} µm", f"{was.max:.0f} µm"),
        ("print time", clock(after.time), clock(before.time)),
    )
    return tuple(
        Card(what, value, name if after is before else f"{name}; {first}: {other}") for what, value, other in figures
    )


def _sheets(simulation: Simulation, named: sheets.Named, called: dict[str, str]) -> tuple[Sheet, ...]:
    """The tables there is something to tell in."""
    told = [sheets.methods(named)]
    if len(simulation.conditions) > 1:
        told.append(sheets.mismatch(named, simulation))
    if len(simulation.results) > len(named):
        told.append(sheets.accelerations(simulation, lambda one: called.get(one.name, one.name)))
    told += [sheets.features(named, simulation.features), sheets.corners(named), sheets.surfaces(named)]
    if any(one.motors.motors for _, one in named):
        told.append(sheets.motors(named))
    return tuple(told)


def _spans(by: dict[int, Three], count: int) -> Spans:
    none = np.full(count, np.nan)
    rms, largest = none.copy(), none.copy()
    for k, errors in by.items():
        rms[k], largest[k] = errors.contour.rms, errors.contour.max
    return Spans(rms, largest)


def _most(named: sheets.Named, kind: str) -> int:
    return 1 + max((k for _, one in named for k in getattr(one.figures[0], kind)), default=-1)


def _faces(named: sheets.Named, features: Sequence[str]) -> tuple[Face, ...]:
    """The longest straight walls across X and Y of the first method, where others drew the same ones."""
    found = []
    for wall in named[0][1].figures[0].walls:
        same = {
            name: other
            for name, one in named
            for other in one.figures[0].walls
            if other.axis == wall.axis and abs(other.line - wall.line) <= 1  # a sample of it may be of the next line
        }
        where = f"line {wall.line + 1}, layer {wall.layer + 1}, {features[wall.feature]}, {'XY'[wall.axis]} swings"
        along, off = ({k: getattr(v, what) for k, v in same.items()} for what in ("along", "off"))
        found.append(Face(where, along, {k: UM_PER_MM * each for k, each in off.items()}))
    return tuple(found)


def _settings(
    simulation: Simulation, named: sheets.Named, settings: Settings, printer: Printer, machine: Printer
) -> tuple[tuple[str, str], ...]:
    pairs = [("printer", printer.name), ("firmware", printer.firmware), ("its model", machine.source)]
    pairs += [(name, _told(one, settings)) for name, one in named]
    conditions = ", ".join(condition.name for condition in simulation.conditions)
    return (*pairs, ("machine", conditions), ("samples", f"{simulation.rate:g} per second"))


def _modes(designs: Designs) -> str:
    """The frequencies that the pictures are to be read with."""
    told = []
    for axis, plant in zip("XY", designs.plants(0), strict=True):
        each = [f"{mode.frequency:.1f} Hz damping {mode.damping:.3f}" for mode in modes(plant)]
        told.append(f"{axis} {', '.join(each) or 'none'}")
    return "; ".join(told)


def _told(one: Simulated, settings: Settings) -> str:
    made = "; made for " + ", ".join(f"{each.frequency:.1f} Hz, damping {each.damping:.3f}" for each in one.made_for)
    told = replace(settings, acceleration=one.acceleration).told(one.method)
    return told + (made if one.made_for else "") + (f" ({one.why})" if one.why else "")
