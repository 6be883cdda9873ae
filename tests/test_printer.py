"""A profile is a Printer, or one line that says which key is wrong and what to write."""

from __future__ import annotations

import copy
import math
import tomllib
from pathlib import Path

import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.errors import ProfileError
from fbfcli.printer import FrequencyResponse, ImpulseResponse, ModalModel, Mode, Printer, TransferFunction
from fbfcli.printer_toml import parse_printer

CONFIGS = sorted((Path(__file__).parents[1] / "configs").glob("*.toml"))
FULL = tomllib.loads("""
[printer]
name = "Test"
source = "made up"
firmware = "klipper"
kinematics = "cartesian"
segments_per_second = 900
nozzle_diameter = 0.6
filament_diameter = 2.85
max_extrude_cross_section = 5.0
note = "anything"

[limits]
velocity = 300
acceleration = 5000
travel_acceleration = 6000
retract_acceleration = 4000
square_corner_velocity = 4
minimum_cruise_ratio = 0.0
junction_deviation = 0.02

[axis.x]
travel = [-10, 260]
steps_per_mm = 80
max_velocity = 250
max_acceleration = 9000
jerk = 8
command_velocity = 400
command_acceleration = 20000
[axis.x.model]
modes = [{ frequency = 45.0, damping = 0.05, gain = 0.7 }, { frequency = 85.0, damping = 0.04, gain = 0.3 }]

[axis.y]
travel = [-10, 260]
steps_per_mm = 80
[axis.y.model]
b = [0.0, 0.5, 0.5]
a = [1.0, 0.0]
dt = 0.001

[axis.z]
travel = [0, 250]
steps_per_mm = 400
max_velocity = 15
max_acceleration = 200

[axis.e]
max_velocity = 75
max_acceleration = 5000
jerk = 1
""")
NOWHERE = object()  # instead of a value: take the key away


def changed(path: str, value: object) -> str:
    """FULL with one key set, added or taken away."""
    whole = copy.deepcopy(FULL)
    *tables, key = path.split("/")
    table = whole
    for name in tables:
        table = table[int(name)] if name.isdigit() else table.setdefault(name, {})
    if value is NOWHERE:
        del table[key]
    else:
        table[key] = value
    return tomlkit.dumps(whole)


def paths_of(table: dict, above: str = "") -> list[str]:
    """Every key of every table."""
    found = []
    for key, value in table.items():
        found.append(above + key)
        if isinstance(value, dict):
            found += paths_of(value, f"{above}{key}/")
        elif isinstance(value, list) and isinstance(value[0], dict):
            found += [p for i, inner in enumerate(value) for p in paths_of(inner, f"{above}{key}/{i}/")]
    return found


PATHS = paths_of(FULL)


def refusal(text: str, read=None) -> str:
    with pytest.raises(ProfileError) as refused:
        parse_printer(text, "mine.toml", read)
    words = str(refused.value)
    assert "\n" not in words
    assert words.startswith("mine.toml: ")
    return words


def test_every_key_arrives():
    printer = parse_printer(tomlkit.dumps(FULL), "mine.toml")
    x, y, z = printer.axes
    limits = printer.limits
    assert (printer.name, printer.firmware, printer.kinematics) == ("Test", "klipper", "cartesian")
    assert (printer.segments_per_second, printer.nozzle_diameter, printer.filament_diameter) == (900.0, 0.6, 2.85)
    assert printer.max_extrude_cross_section == 5.0
    assert (limits.velocity, limits.acceleration, limits.travel_acceleration) == (300, 5000, 6000)
    assert (limits.retract_acceleration, limits.square_corner_velocity, limits.minimum_cruise_ratio) == (4000, 4, 0)
    assert limits.junction_deviation == 0.02
    assert limits.axis_velocity == (250, math.inf, 15, 75)
    assert limits.axis_acceleration == (9000, math.inf, 200, 5000)
    assert limits.jerk == (8, math.inf, math.inf, 1)
    assert (x.travel, x.steps_per_mm, x.command_velocity, x.command_acceleration) == ((-10, 260), 80, 400, 20000)
    assert x.model == ModalModel((Mode(45.0, 0.05, 0.7), Mode(85.0, 0.04, 0.3)))
    assert y.model == TransferFunction((0.0, 0.5, 0.5), (1.0, 0.0), 0.001)
    assert z.model is None


def test_what_is_not_said_is_what_the_document_states():
    x, y, _ = parse_printer(changed("axis/x/command_velocity", NOWHERE), "mine.toml").axes
    assert x.command_velocity == 1.5 * 250  # the axis' own limit, lower than the printer's
    assert (y.command_velocity, y.command_acceleration) == (1.5 * 300, 3 * 6000)
    printer = parse_printer(changed("printer/segments_per_second", NOWHERE), "mine.toml")
    assert printer.segments_per_second == 1000
    assert parse_printer(changed("limits/travel_acceleration", NOWHERE), "mine.toml").limits.travel_acceleration == 5000
    klipper = parse_printer(changed("printer/max_extrude_cross_section", NOWHERE), "mine.toml")
    assert klipper.max_extrude_cross_section == pytest.approx(4 * 0.6**2)  # klippy/kinematics/extruder.py
    assert parse_printer(changed("axis/e", NOWHERE), "mine.toml").limits.axis_velocity[3] == math.inf


@pytest.mark.parametrize("file", CONFIGS, ids=lambda file: file.stem)
def test_bundled_profiles_are_good_and_say_where_they_come_from(file):
    printer = parse_printer(file.read_text(), file.name)
    assert "Ramani" in printer.source or "synthetic" in printer.source
    assert all(axis.model is not None for axis in printer.axes[:2])
    assert ("synthetic" in file.stem) == ("synthetic" in printer.source)


@pytest.mark.parametrize(("path", "value", "words"), [
    ("printer", NOWHERE, ["printer: is missing", "[printer]"]),
    ("axis", NOWHERE, ["axis: is missing"]),
    ("axis/z", NOWHERE, ["axis.z: is missing"]),
    ("limits", 3, ["limits = 3: must be a section", "[limits]"]),
    ("limits/acceleration", NOWHERE, ["limits.acceleration: is missing"]),
    ("limits/velocity", NOWHERE, ["limits.velocity: is missing"]),
    ("limits/accelaration", 3000, ["limits.accelaration = 3000: unknown key", "did you mean acceleration?"]),
    ("limits/a\nb", 3, ["limits.'a\\nb' = 3: unknown key"]),
    ("axis/u", {}, ["axis.u", "unknown key", "x, y, z, e"]),
    ("axis/z/model", {}, ["axis.z.model", "unknown key"]),
    ("limits/velocity", math.nan, ["limits.velocity = nan: must be a finite number"]),
    ("limits/velocity", math.inf, ["limits.velocity = inf: must be a finite number"]),
    ("limits/velocity", -300.0, ["limits.velocity = -300.0: must be greater than 0"]),
    ("limits/velocity", 0, ["must be greater than 0"]),
    ("limits/velocity", "300", ["limits.velocity = '300': must be a number", "without quotes"]),
    ("limits/velocity", True, ["must be a number"]),
    ("limits/velocity", [300], ["must be a number"]),
    ("limits/minimum_cruise_ratio", 1.0, ["must be less than 1"]),
    ("limits/minimum_cruise_ratio", -0.1, ["must not be less than 0"]),
    ("axis/x/travel", [260, -10], ["axis.x.travel = [260, -10]", "travel = [-10, 260]?"]),
    ("axis/x/travel", [0], ["must be two numbers"]),
    ("axis/x/travel", [0, math.nan], ["must be a finite number"]),
    ("axis/x/travel", 260, ["must be a list of numbers"]),
    ("axis/x/steps_per_mm", NOWHERE, ["axis.x.steps_per_mm: is missing"]),
    ("printer/firmware", "kliper", ["printer.firmware = 'kliper': is not known", "did you mean klipper?"]),
    ("printer/firmware", "grbl", ["one of klipper, marlin, reprapfirmware"]),
    ("printer/kinematics", "CoreXY", ["did you mean corexy?"]),
    ("printer/name", 3, ["must be one line of text"]),
    ("printer/name", "a\nb", ["must be one line of text"]),
    ("printer/note", 3, ["printer.note = 3: must be text"]),
    ("axis/x/model/modes/0/gain", 0.6, ["the gains sum to 0.9, not 1"]),
    ("axis/x/model/modes/1/damping", 1.0, ["axis.x.model.modes[1].damping = 1.0: must be less than 1"]),
    ("axis/x/model/modes/1/damping", 0.0, ["must be greater than 0"]),
    ("axis/x/model/modes/0/frequency", NOWHERE, ["axis.x.model.modes[0].frequency: is missing"]),
    ("axis/x/model/modes/0/zeta", 0.1, ["modes[0].zeta = 0.1: unknown key"]),
    ("axis/x/model/modes", [], ["must be a list of tables"]),
    ("axis/x/model/modes", NOWHERE, ["axis.x.model.modes: is missing", "frequency_response"]),
    ("axis/x/model/b", [1.0], ["a model has exactly one form"]),
    ("axis/y/model/a", [0.0, 1.0], ["must not begin with 0"]),
    ("axis/y/model/a", NOWHERE, ["axis.y.model.a: is missing"]),
    ("axis/y/model/b", [0.0], ["is zero throughout"]),
    ("axis/y/model/dt", 1, ["axis.y.model.dt = 1: must be less than 0.1"]),
    ("axis/y/model", {"impulse_response": "h.csv", "dt": 0.001}, ["nowhere to look for it"]),
])
def test_refusals_name_key_value_and_remedy(path, value, words):
    said = refusal(changed(path, value))
    for part in words:
        assert part in said


def test_each_firmware_gets_what_it_plans_with():
    marlin = tomllib.loads(changed("printer/firmware", "marlin"))
    assert "axis.y.max_velocity: is missing" in refusal(tomlkit.dumps(marlin))  # raised, it could not be put back
    marlin["axis"]["y"] |= {"max_velocity": 300, "max_acceleration": 3000}
    reprap = copy.deepcopy(marlin)
    reprap["printer"]["firmware"] = "reprapfirmware"
    assert "axis.y.jerk: is missing" in refusal(tomlkit.dumps(reprap))
    del marlin["limits"]["junction_deviation"]
    assert "junction_deviation" in refusal(tomlkit.dumps(marlin))
    marlin["axis"]["y"]["jerk"] = 8
    del marlin["limits"]["velocity"]
    limits = parse_printer(tomlkit.dumps(marlin), "mine.toml").limits
    assert limits.velocity == math.inf
    assert math.isnan(limits.junction_deviation)


def with_csv(form: str, csv: str, **keys: object) -> ImpulseResponse | FrequencyResponse | str:
    """The model of X read from a CSV, or the refusal."""
    text = changed("axis/x/model", {form: "sub/r.csv", **keys})
    files = {"sub/r.csv": csv}
    try:
        return parse_printer(text, "mine.toml", files.__getitem__).axes[0].model
    except ProfileError:
        return refusal(text, files.__getitem__)


def test_responses_are_read_from_csv():
    assert with_csv("impulse_response", "# of X\n0.25\n0.75\n", dt=0.001) == ImpulseResponse((0.25, 0.75), 0.001)
    assert with_csv("impulse_response", "h\n0.25\r\n0.75\r\n", dt=0.001) == ImpulseResponse((0.25, 0.75), 0.001)
    assert with_csv("frequency_response", "frequency, magnitude, phase\n1,1,0\n2,1.1,-0.1\n") == FrequencyResponse(
        (1.0, 2.0), (1.0, 1.1), (0.0, -0.1))
    degrees = with_csv("frequency_response", "Frequency,Magnitude,Phase_deg\n1,1,0\n2,1.1,-180\n")
    assert degrees.phase == (0.0, -math.pi)


@pytest.mark.parametrize(("form", "csv", "words"), [
    ("frequency_response", "frequency,magnitude\n1,1\n2,1\n", "columns frequency,magnitude"),
    ("frequency_response", "1,1,0\n2,1,0\n", "frequency,magnitude,phase"),
    ("frequency_response", "frequency,magnitude,phase\n2,1,0\n1,1,0\n", "must rise"),
    ("frequency_response", "frequency,magnitude,phase\n1,-3,0\n2,1,0\n", "not dB"),
    ("frequency_response", "frequency,magnitude,phase\n1,1,0\n2,nan,0\n", "row 2 is not 3 finite numbers"),
    ("frequency_response", "frequency,magnitude,phase\n1,1\n2,1,0\n", "row 1 is not 3 finite numbers"),
    ("frequency_response", "", "fewer than two rows"),
])
def test_bad_responses_are_refused(form, csv, words):
    assert words in with_csv(form, csv)


def test_impulse_response_needs_its_period():
    assert "axis.x.model.dt: is missing" in with_csv("impulse_response", "1\n0\n")
    assert "must have one column" in with_csv("impulse_response", "1,2\n0,1\n", dt=0.001)


@pytest.mark.parametrize("text", ["=", "a" * 1000, "[printer\n", f"x = {'9' * 5000}", "x = " + "[" * 9000])
def test_what_is_not_a_profile_is_one_line(text):
    refusal(text)


values = st.recursive(
    st.none().map(lambda _: NOWHERE) | st.booleans() | st.integers() | st.floats() | st.text("aé\n\"' #", max_size=4),
    lambda inner: st.lists(inner.filter(lambda v: v is not NOWHERE), max_size=3), max_leaves=4)


@given(path=st.sampled_from(PATHS), value=values)
def test_any_value_anywhere_is_a_printer_or_one_line(path, value):
    try:
        printer = parse_printer(changed(path, value), "mine.toml")
    except ProfileError as refused:
        assert str(refused).startswith("mine.toml: ")
        assert "\n" not in str(refused)
        return
    assert isinstance(printer, Printer)
    for axis in printer.axes:
        assert axis.travel[0] < axis.travel[1]
        assert min(axis.steps_per_mm, axis.command_velocity, axis.command_acceleration) > 0
    limits = printer.limits
    assert min(limits.velocity, limits.acceleration, *limits.axis_velocity, *limits.axis_acceleration, *limits.jerk) > 0


@given(st.text())
def test_any_text_is_refused(text):
    refusal(text)


def test_the_documents_example_is_good():
    document = (Path(__file__).parents[1] / "docs" / "printer-profile.md").read_text()
    example = document.split("```toml\n")[1].split("```")[0]
    printer = parse_printer(example, "printer-profile.md")
    assert printer.axes[0].command_acceleration == 3 * 5000
    assert printer.axes[1].model == ModalModel((Mode(28.0, 0.05),))


def test_the_document_names_every_key():
    document = (Path(__file__).parents[1] / "docs" / "printer-profile.md").read_text()
    keys = {path.split("/")[-1] for path in PATHS if not path.split("/")[-1].isdigit()}
    assert {key for key in keys if f"`{key}`" not in document and f"{key} =" not in document} <= {
        "printer", "limits", "axis", "x", "y", "z", "e"}
