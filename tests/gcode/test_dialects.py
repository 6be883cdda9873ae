"""The same command, three firmwares."""

from __future__ import annotations

from math import inf

import pytest
from reading_cases import block_of

from fbfcli.errors import GcodeError
from fbfcli.gcode.dialects import Kind, effect_of, parse_command
from fbfcli.gcode.limit_commands import changed
from fbfcli.printer import FIRMWARES, Limits

POWER_ON = Limits(velocity=300, acceleration=3000, travel_acceleration=3000, retract_acceleration=3000)


def limits_after(text, firmware):
    return changed(POWER_ON, effect_of(text, firmware).limits)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("M104 S200", Kind.IN_ORDER), ("M106 S255", Kind.IN_ORDER), ("M117 Layer {1}", Kind.IN_ORDER),
        ("M900 K.05", Kind.IN_ORDER), ("M862.3 P \"MK3S\"", Kind.IN_ORDER), ("M486 S1", Kind.IN_ORDER),
        ("EXCLUDE_OBJECT_START NAME=cube", Kind.IN_ORDER), ("M221 S95", Kind.IN_ORDER),
        ("SET_PRESSURE_ADVANCE ADVANCE=.02", Kind.IN_ORDER), ("set_fan_speed fan=a speed=1", Kind.IN_ORDER),
        ("M73 P1 R2", Kind.PROGRESS), ("G90", Kind.MODE), ("M83", Kind.MODE), ("G92 E0", Kind.MODE),
        ("M220 S90", Kind.MODE), ("G28 X Y", Kind.BARRIER), ("G29", Kind.BARRIER), ("G4 P10", Kind.BARRIER),
        ("M400", Kind.BARRIER), ("T0", Kind.BARRIER), ("M109 S200", Kind.BARRIER),
        ("TIMELAPSE_TAKE_FRAME", Kind.BARRIER), ("PRINT_START BED=60", Kind.BARRIER),
        ("M600", Kind.BARRIER), ("M84", Kind.BARRIER), ("G10", Kind.RETRACT), ("G11", Kind.RETRACT),
        ("G10 S200 P0", Kind.IN_ORDER), ("G10 P1 X-16.5", Kind.BARRIER),
    ],
)  # fmt: skip
@pytest.mark.parametrize("firmware", FIRMWARES)
def test_kinds(text, kind, firmware):
    assert effect_of(text, firmware).kind == kind


def test_what_loses_the_position():
    assert not effect_of("M400", "marlin").lost and not effect_of("M109 S200", "marlin").lost
    assert effect_of("T1", "marlin").lost and effect_of("UNHEARD_OF", "klipper").lost


@pytest.mark.parametrize(
    ("text", "firmware", "seconds"),
    [
        ("G4 P1500", "marlin", 1.5), ("G4 S2", "marlin", 2), ("G4 S2 P5", "marlin", 2), ("G4 S2", "reprapfirmware", 2),
        ("G4 P250", "klipper", 0.25), ("G4 S2", "klipper", 0), ("G4", "marlin", 0), ("N5 G4 P1000*33", "marlin", 1),
    ],
)  # fmt: skip
def test_dwell(text, firmware, seconds):
    assert effect_of(text, firmware).wait == seconds


@pytest.mark.parametrize(
    ("text", "homed"), [("G28", (0, 1, 2)), ("G28 XY", (0, 1)), ("G28 Z0", (2,)), ("G28 W", (0, 1, 2))]
)
def test_homed_axes(text, homed):
    assert effect_of(text, "marlin").homed == homed


def test_m204():
    marlin = limits_after("M204 P800 R1250 T900", "marlin")
    assert (marlin.acceleration, marlin.travel_acceleration, marlin.retract_acceleration) == (800, 900, 1250)
    assert limits_after("M204 S700", "marlin").travel_acceleration == 700
    assert limits_after("M204 P800 T900", "klipper").acceleration == 800
    assert limits_after("M204 P800", "klipper") == POWER_ON
    assert limits_after("M204 P800 R5 T900", "reprapfirmware").retract_acceleration == 3000


def test_units_of_speeds():
    assert limits_after("M203 X200 E50", "marlin").axis_velocity[0] == 200
    assert limits_after("M203 X12000 E3000:3000", "reprapfirmware").axis_velocity == (200, inf, inf, 50)
    assert limits_after("M203 S1 X200", "reprapfirmware").axis_velocity[0] == 200
    assert limits_after("M566 X600", "reprapfirmware").jerk[0] == 10
    assert limits_after("M205 X8 Y7", "marlin").jerk[:2] == (8, 7)
    assert limits_after("M205 J.02 S0 T0 B0", "marlin").junction_deviation == 0.02


def test_velocity_limit():
    text = "SET_VELOCITY_LIMIT VELOCITY=150 ACCEL=2000 SQUARE_CORNER_VELOCITY=7 MINIMUM_CRUISE_RATIO=.25"
    after = limits_after(text, "klipper")
    assert (after.velocity, after.acceleration, after.square_corner_velocity) == (150, 2000, 7)
    assert after.minimum_cruise_ratio == 0.25
    assert limits_after("SET_VELOCITY_LIMIT ACCEL=500 ACCEL_TO_DECEL=250", "klipper").minimum_cruise_ratio == 0.5


@pytest.mark.parametrize(
    ("text", "firmware"),
    [("SET_VELOCITY_LIMIT ACCEL=5", "marlin"), ("M566 X6", "klipper"), ("M203 X5", "klipper"), ("M566 X6", "marlin")],
)
def test_a_limit_that_a_firmware_does_not_know_is_in_order(text, firmware):
    effect = effect_of(text, firmware)
    assert effect.kind == Kind.IN_ORDER and not effect.limits


@pytest.mark.parametrize(
    "text",
    ["M204 S0", "M204 Sx", "M204 S1" + 400 * "0", "G4 P" + 400 * "9", "M220 S0", "G93", "G90.1", "M205 J-1"],
)
def test_nonsense_is_refused(text):
    with pytest.raises(GcodeError):
        effect_of(text, "marlin")


def test_names_are_normal():
    assert parse_command("n12 g01.0 x5*7").name == "G1"
    assert parse_command("G0028 x").name == "G28"
    assert parse_command("g28xy").words.keys() == {"X", "Y"}
    assert parse_command("Set_Pin PIN=\"my led\" value=1").words == {"PIN": "my led", "VALUE": "1"}


def test_time_comments_are_progress():
    block = block_of(";TIME:10\n;TYPE:FILL\nG1 X1 ;TIME:5\n; estimated printing time (normal mode) = 5s\nM73 P4\n")
    kinds = [Kind.PROGRESS, Kind.BLANK, Kind.MOTION, Kind.PROGRESS, Kind.PROGRESS]
    assert block.kind.tolist() == kinds


def test_steps_per_mm_are_reported():
    assert block_of("M92 X80\nM92 Y80").warnings == ("M92 changes the steps per mm: is the profile still right?",)
