"""Motors and loads as a profile says them: nouns, or one line that says what is wrong."""

from __future__ import annotations

import tomllib

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.cli.lookup import bundled
from fbfcli.errors import ProfileError
from fbfcli.printer import Axis, Load
from fbfcli.printer_toml import parse_printer
from fbfcli.verify.rotor import rotor_of
from fbfcli.verify.torque_speed import standstill_torque
from tests.test_printer import FULL

SHEET = {
    "holding_torque": 0.59, "rated_current": 2.0, "resistance": 1.4, "inductance_mh": 3.0, "rotor_inertia_gcm2": 82,
    "supply_voltage": 24,
}  # fmt: skip
LOAD = {"mass": 0.5, "friction": 3.0, "viscous": 10.0}


def axes(kinematics: str = "cartesian", steps_per_mm: float = 80.0, **tables: object) -> tuple[Axis, Axis, Axis]:
    """Axes of a profile with these tables in [axis.x]; those that begin with y_ in [axis.y]."""
    whole = tomllib.loads(tomlkit.dumps(FULL))
    whole["printer"]["kinematics"] = kinematics
    whole["axis"]["x"]["steps_per_mm"] = steps_per_mm
    for name, table in tables.items():
        whole["axis"]["y" if name.startswith("y_") else "x"][name.removeprefix("y_")] = table
    return parse_printer(tomlkit.dumps(whole), "mine.toml").axes


def refusal(**keys: object) -> str:
    with pytest.raises(ProfileError) as refused:
        axes(**{"load": LOAD} | keys)
    words = str(refused.value)
    assert "\n" not in words and words.startswith("mine.toml: axis.")
    return words


def test_a_profile_may_be_silent_about_motors():
    assert all(axis.motor is None and axis.load is None for axis in axes())


def test_a_data_sheet_is_read_in_its_units():
    x = axes(motor=SHEET, load=LOAD)[0]
    assert x.load == Load(0.5, 3.0, 0.01)
    motor = x.motor
    assert motor is not None
    assert (motor.inductance, motor.rotor_inertia) == pytest.approx((3e-3, 82e-7))
    assert (motor.full_steps, motor.microsteps, motor.mm_per_turn, motor.run_current) == (200, 16, 40.0, 2.0)
    assert standstill_torque(motor) == pytest.approx(0.59)


@given(st.sampled_from([200, 400]), st.sampled_from([1, 8, 16, 64, 256]), st.floats(2.0, 60.0))
@settings(max_examples=30)
def test_what_pulley_and_drive_give_must_be_steps_per_mm(full_steps, microsteps, mm_per_turn):
    drive = {"full_steps": full_steps, "microsteps": microsteps, "mm_per_turn": mm_per_turn}
    per_mm = full_steps * microsteps / mm_per_turn
    assert axes(steps_per_mm=per_mm * 1.005, motor=SHEET | drive, load=LOAD)[0].motor is not None
    words = refusal(steps_per_mm=per_mm * 2.0, motor=SHEET | drive)
    assert "mm_per_turn" in words and "steps_per_mm" in words


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [("holding_torque", -1, "greater than 0"), ("rotor_inertia", 82, "did you mean rotor_inertia_gcm2"),
     ("microsteps", 17, "one of 1, 2, 4"), ("full_steps", 48, "one of 200, 400"), ("run_current", 800, "less than 3"),
     ("interpolation", "yes", "true or false"), ("damping", 1.0, "less than 1"), ("detent_torque", 0.4, "less than")],
)  # fmt: skip
def test_what_cannot_be_is_refused(key, value, why):
    assert why in refusal(motor=SHEET | {key: value})


@pytest.mark.parametrize("key", SHEET)
def test_every_value_of_the_data_sheet_is_needed(key):
    assert f"axis.x.motor.{key}: is missing" in refusal(motor={k: v for k, v in SHEET.items() if k != key})


def test_a_motor_without_its_load_is_refused():
    words = refusal(motor=SHEET, load=LOAD, y_motor=SHEET)
    assert "axis.y.load: is missing" in words and "motor of Y" in words


def test_on_a_corexy_every_motor_moves_both_axes():
    assert "axis.y.load" in refusal(kinematics="corexy", motor=SHEET)
    assert axes("corexy", motor=SHEET, load=LOAD, y_load=LOAD)[1].motor is None


def test_two_bundled_profiles_have_motors_that_turn_as_such_motors_do():
    """A NEMA 17 rotor in its field oscillates at 100 to 400 Hz (a mass on the shaft would be slower)."""
    motors = {axis.motor.name: axis.motor for printer in bundled().values() for axis in printer.axes if axis.motor}
    assert len(motors) >= 2
    for motor in motors.values():
        assert 100.0 < rotor_of(motor).w / 6.2832 < 400.0
