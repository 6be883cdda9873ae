"""Printer profiles: TOML text in, a Printer out, validated once. The format is described in docs/printer-profile.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from itertools import pairwise
from math import inf, nan, radians

from fbfcli.coupling_toml import coupling
from fbfcli.errors import ProfileError
from fbfcli.motor_toml import check_motors, load, motor
from fbfcli.printer import (
    FIRMWARES,
    KINEMATICS,
    Axis,
    Driver,
    FrequencyResponse,
    ImpulseResponse,
    Limits,
    ModalModel,
    Mode,
    Model,
    Printer,
    TransferFunction,
)
from fbfcli.toml_table import Table, parse_toml
from fbfcli.uncertainty_toml import MODEL_KEYS, places, uncertainty
from fbfcli.units import NS_PER_S

SEGMENTS_PER_SECOND = {"klipper": 1000.0, "marlin": 300.0, "reprapfirmware": 200.0}  # Marlin: 32-bit board, from SD
GAIN_TOLERANCE = 1e-3  # of the sum of a model's gains: half a unit of the last digit people write
KLIPPER_CORNER = 1.0  # mm/s, instantaneous_corner_velocity where it is not configured
COMMAND_VELOCITY_FACTOR = 1.5  # a compensated command overshoots the desired speed ...
COMMAND_ACCELERATION_FACTOR = 3.0  # ... and swings well past the planned acceleration
PLA = 1.24  # g/cm^3
KG_MM3_PER_G_CM3 = 1e-6
HIGHEST_MODE = 500.0  # Hz: a trajectory of 1 kHz holds nothing above
MODEL_FORMS = MODEL_KEYS[:4]  # what each form is known by
EXAMPLE_MODES = "modes = [{frequency = 35.0, damping = 0.05}]"

Read = Callable[[str], str]


def parse_printer(text: str, file: str, read: Read | None = None) -> Printer:
    """The printer that a profile describes.

    text : the profile, TOML
    file : its name, for messages
    read : gives the text of a CSV that the profile names, by the name as written; without it such models are refused

    Raises ProfileError: one line with file, key, value and remedy.
    """
    whole = parse_toml(text, file).only("printer", "limits", "axis", "driver")
    about = whole.table("printer").only(
        "name", "source", "firmware", "kinematics", "segments_per_second", "nozzle_diameter", "filament_diameter",
        "filament_density", "max_extrude_cross_section", "delta_radius", "arm_length")
    firmware = about.choice("firmware", FIRMWARES)
    nozzle = about.number("nozzle_diameter", 0.4, below=20.0)
    # Klipper's own default, klippy/kinematics/extruder.py; the others do not look at the cross-section
    thickest = 4.0 * nozzle**2 if firmware == "klipper" else inf
    axes = whole.table("axis").only("x", "y", "z", "e")
    limits = _limits(whole.table("limits"), axes, firmware)
    kinematics = about.choice("kinematics", KINEMATICS)
    built = (_axis(axes.table("x"), 0, limits, read), _axis(axes.table("y"), 1, limits, read),
             _axis(axes.table("z"), 2, limits, read))
    check_motors(axes, built, kinematics)
    return Printer(
        name=about.text("name"),
        source=about.text("source", "not stated"),
        firmware=firmware,
        kinematics=kinematics,
        axes=built,
        limits=limits,
        segments_per_second=about.number("segments_per_second", SEGMENTS_PER_SECOND[firmware]),
        nozzle_diameter=nozzle,
        max_extrude_cross_section=about.number("max_extrude_cross_section", thickest),
        filament_diameter=about.number("filament_diameter", 1.75, below=20.0),
        e_steps_per_mm=_optional(axes.table("e"), "steps_per_mm") if "e" in axes.values else None,
        delta_radius=_optional(about, "delta_radius"),
        arm_length=_arm_length(about),
        driver=_driver(whole.table("driver")) if "driver" in whole.values else Driver(),
        filament_density=about.number("filament_density", PLA, below=25.0) * KG_MM3_PER_G_CM3,
    )


def _optional(table: Table, key: str) -> float | None:
    return table.number(key) if key in table.values else None


def _arm_length(about: Table) -> float | None:
    arm, radius = _optional(about, "arm_length"), _optional(about, "delta_radius")
    if arm is not None and radius is not None and arm <= radius:
        about.refuse("arm_length", f"is not longer than delta_radius = {radius:g}", "the bed's centre must be in reach")
    return arm


def _driver(table: Table) -> Driver:
    table.only("step_pulse_ns", "direction_setup_ns", "max_step_rate", "hysteresis")
    usual = Driver()
    pulse = table.number("step_pulse_ns", usual.step_pulse * NS_PER_S) / NS_PER_S
    rate = table.number("max_step_rate", usual.max_step_rate)
    if 2.0 * pulse * rate > 1.0:
        table.refuse("max_step_rate" if "max_step_rate" in table.values else "step_pulse_ns",
                     f"{rate:g} steps/s leave no room for a pulse and a pause of {pulse * NS_PER_S:g} ns each",
                     f"at most {0.5 / pulse:.0f} steps/s")
    setup = table.number("direction_setup_ns", usual.direction_setup * NS_PER_S, above=-inf, least=0.0)
    hysteresis = table.number("hysteresis", usual.hysteresis, above=-inf, least=0.0, below=0.5)
    return Driver(pulse, setup / NS_PER_S, rate, hysteresis)


def _limits(table: Table, axes: Table, firmware: str) -> Limits:
    table.only(*(f.name for f in fields(Limits) if f.name not in ("axis_velocity", "axis_acceleration", "jerk")))
    acceleration = table.number("acceleration")
    velocity = table.number("velocity", None if firmware == "klipper" else inf)
    per_axis = [axes.table(name) for name in "xyz"] + ([axes.table("e")] if "e" in axes.values else [])
    if len(per_axis) == 4:
        per_axis[3].only("max_velocity", "max_acceleration", "jerk", "steps_per_mm")

    def four(key: str) -> tuple[float, float, float, float]:
        x, y, z, e = [t.number(key, inf) for t in per_axis] + [inf] * (4 - len(per_axis))
        return x, y, z, e

    jerk = four("jerk")
    if firmware == "klipper":
        jerk = (*jerk[:3], KLIPPER_CORNER if jerk[3] == inf else jerk[3])
    else:  # they are raised for a compensated stretch, and what is raised must be put back
        for key in ("max_velocity", "max_acceleration"):
            for table_of_axis in per_axis[:2]:
                table_of_axis.number(key)
    if firmware == "marlin" and "junction_deviation" not in table.values and inf in jerk[:2]:
        table.refuse("junction_deviation", "is missing", "Marlin needs it, or jerk in [axis.x] and [axis.y]")
    if firmware == "reprapfirmware" and inf in jerk[:2]:
        axes.table("x" if jerk[0] == inf else "y").refuse("jerk", "is missing", "RepRapFirmware needs it: M566 / 60")
    return Limits(
        velocity=velocity,
        acceleration=acceleration,
        travel_acceleration=table.number("travel_acceleration", acceleration),
        retract_acceleration=table.number("retract_acceleration", acceleration),
        axis_velocity=four("max_velocity"),
        axis_acceleration=four("max_acceleration"),
        jerk=jerk,
        junction_deviation=table.number("junction_deviation", nan, below=10.0),
        square_corner_velocity=table.number("square_corner_velocity", 5.0, above=-inf, least=0.0),
        minimum_cruise_ratio=table.number("minimum_cruise_ratio", 0.5, above=-inf, least=0.0, below=1.0),
    )


def _axis(table: Table, index: int, limits: Limits, read: Read | None) -> Axis:
    """One of X, Y, Z; the keys that Limits takes are checked there. Z is never compensated and has no model."""
    name = "XYZ"[index]
    of_flat = ["model", "uncertainty", "at", "coupling"] if name != "Z" else []
    table.only("travel", "steps_per_mm", "max_velocity", "max_acceleration", "jerk", "command_velocity",
               "command_acceleration", "motor", "load", *of_flat)
    travel = table.numbers("travel", "travel = [0, 200]")
    if len(travel) != 2:
        table.refuse("travel", "must be two numbers", "lowest and highest position: travel = [0, 200]")
    if not travel[0] < travel[1]:
        table.refuse("travel", "the lowest position must come first", f"travel = [{travel[1]:g}, {travel[0]:g}]?")
    velocity = min(limits.velocity, limits.axis_velocity[index])
    acceleration = min(max(limits.acceleration, limits.travel_acceleration), limits.axis_acceleration[index])

    def model_of(inner: Table, gain: float = 1.0) -> Model:
        return _model(inner, read, gain)

    at = places(table, model_of) if "at" in table.values else ()
    steps_per_mm = table.number("steps_per_mm")
    return Axis(
        name=name,
        travel=(travel[0], travel[1]),
        steps_per_mm=steps_per_mm,
        command_velocity=table.number("command_velocity", COMMAND_VELOCITY_FACTOR * velocity),
        command_acceleration=table.number("command_acceleration", COMMAND_ACCELERATION_FACTOR * acceleration),
        model=model_of(table.table("model")) if "model" in table.values else at[0].model if at else None,
        uncertainty=uncertainty(table, model_of) if "uncertainty" in table.values else None,
        at=at,
        coupling=coupling(table, model_of) if "coupling" in table.values else None,
        motor=motor(table, steps_per_mm) if "motor" in table.values else None,
        load=load(table) if "load" in table.values else None,
    )


def _model(table: Table, read: Read | None, gain: float) -> Model:
    table.only(*MODEL_KEYS)
    forms = [form for form in MODEL_FORMS if form in table.values]
    if len(forms) != 1:
        table.refuse(forms[1] if forms else "modes", "a model has exactly one form" if forms else "is missing",
                     f"one of {', '.join(MODEL_FORMS)}")
    form = forms[0]
    table.only(*{"b": ("b", "a", "dt"), "impulse_response": (form, "dt")}.get(form, (form,)))
    if form == "modes":
        return _modal(table, gain)
    if form == "b":
        return _transfer_function(table)
    columns = _columns(table, form, read)
    if form == "impulse_response":
        if len(columns) != 1:
            table.refuse(form, "must have one column", "one value per line, dt apart")
        return ImpulseResponse(columns[0][1], _period(table))
    return _frequency_response(table, columns)


def _modal(table: Table, gain: float) -> ModalModel:
    modes = tuple(_mode(each.only("frequency", "damping", "gain")) for each in table.tables("modes", EXAMPLE_MODES))
    total = sum(mode.gain for mode in modes)
    if abs(total - gain) > GAIN_TOLERANCE:
        table.refuse("modes", f"the gains sum to {total:g}, not {gain:g}",
                     f"each mode has gain = <part>, together {gain:g}: at rest "
                     f"{'the position is the command' if gain else 'the other axis moves nothing'}")
    return ModalModel(modes)


def _mode(table: Table) -> Mode:
    return Mode(table.number("frequency", below=HIGHEST_MODE), table.number("damping", below=1.0),
                table.number("gain", 1.0, above=-inf))


def _transfer_function(table: Table) -> TransferFunction:
    b = table.numbers("b", "b = [...], coefficients of z^0, z^-1, ...")
    a = table.numbers("a", "a = [1.0, ...], coefficients of z^0, z^-1, ...")
    if a[0] == 0.0:
        table.refuse("a", "must not begin with 0", "the first is the coefficient of z^0, usually 1.0")
    if not any(b):
        table.refuse("b", "is zero throughout")
    return TransferFunction(b, a, _period(table))


def _period(table: Table) -> float:
    return table.number("dt", below=0.1)  # seconds; 0.1 s could not show a 5 Hz mode: somebody meant ms


def _frequency_response(table: Table, columns: list[tuple[str, tuple[float, ...]]]) -> FrequencyResponse:
    names = tuple(name for name, _ in columns)
    if names not in (("frequency", "magnitude", "phase"), ("frequency", "magnitude", "phase_deg")):
        table.refuse("frequency_response", f"has the columns {','.join(names)}",
                     "frequency,magnitude,phase (Hz, ratio, rad) or frequency,magnitude,phase_deg")
    frequency, magnitude, phase = (values for _, values in columns)
    if any(high <= low for low, high in pairwise(frequency)) or frequency[0] < 0.0:
        table.refuse("frequency_response", "frequencies must not be negative, and must rise from line to line")
    if min(magnitude) < 0.0:
        table.refuse("frequency_response", "a magnitude is negative", "a ratio, not dB")
    if names[2] == "phase_deg":
        phase = tuple(radians(p) for p in phase)
    return FrequencyResponse(frequency, magnitude, phase)


def _columns(table: Table, key: str, read: Read | None) -> list[tuple[str, tuple[float, ...]]]:
    """Columns of the CSV that `key` names: (heading, values). Without a headings line the headings are empty."""
    name = table.text(key)
    if read is None:
        table.refuse(key, "names a file, and there is nowhere to look for it", "give the profile as a file")
    try:
        text = read(name)
    except ProfileError as why:
        table.refuse(key, str(why), "it is looked for beside the profile")
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    rows = [[cell.strip() for cell in line.split(",")] for line in lines]
    heading = [""] * len(rows[0]) if rows else []
    if rows and not _is_number(rows[0][0]):
        heading = [cell.lower() for cell in rows.pop(0)]
    if len(rows) < 2:
        table.refuse(key, "holds fewer than two rows of numbers")
    for number, row in enumerate(rows, 1):
        if len(row) != len(heading) or not all(map(_is_number, row)):
            table.refuse(key, f"row {number} is not {len(heading)} finite numbers: {','.join(row)[:40]!r}")
    return list(zip(heading, (tuple(map(float, column)) for column in zip(*rows, strict=True)), strict=True))


def _is_number(text: str) -> bool:
    try:
        return abs(float(text)) < inf
    except ValueError:
        return False
