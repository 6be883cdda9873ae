"""What a profile says of drivers, of the extruder's steps and of a delta's size."""

from __future__ import annotations

from pathlib import Path

import pytest

from fbfcli.errors import ProfileError
from fbfcli.printer import Driver, Printer
from fbfcli.printer_toml import parse_printer

TEXT = (Path(__file__).parents[1] / "configs" / "synthetic_two_mode.toml").read_text()


def with_driver(table: str) -> Printer:
    return parse_printer(TEXT + "\n[driver]\n" + table, "mine.toml")


def test_without_a_table_it_is_the_slowest_of_the_usual_drivers():
    assert parse_printer(TEXT, "mine.toml").driver == Driver() == with_driver("").driver


def test_times_are_in_ns_and_rates_in_steps_per_second():
    driver = with_driver("step_pulse_ns = 100\ndirection_setup_ns = 20\nmax_step_rate = 1e6\nhysteresis = 0").driver
    assert driver == Driver(pytest.approx(1e-7), pytest.approx(2e-8), 1e6, 0.0)


@pytest.mark.parametrize(("table", "told"), [
    ("step_pulse_ns = 0", "driver.step_pulse_ns = 0: must be greater than 0"),
    ("direction_setup_ns = -1", "driver.direction_setup_ns = -1"),
    ("max_step_rate = -5", "driver.max_step_rate = -5"),
    ("step_pulse_ns = 5000", "driver.step_pulse_ns = 5000: 250000 steps/s leave no room"),
    ("hysteresis = 0.5", "driver.hysteresis = 0.5: must be less than 0.5"),
    ("pulse = 1", "driver.pulse = 1: unknown key"),
])  # fmt: skip
def test_what_cannot_be_is_refused(table, told):
    with pytest.raises(ProfileError) as error:
        with_driver(table)
    assert told in str(error.value)


def test_the_extruders_steps_are_optional_and_above_zero():
    assert parse_printer(TEXT, "mine.toml").e_steps_per_mm == 400.0
    without = TEXT.replace("[axis.e]\nsteps_per_mm = 400.0", "[axis.e]")
    assert parse_printer(without, "mine.toml").e_steps_per_mm is None
    with pytest.raises(ProfileError, match=r"axis\.e\.steps_per_mm = 0"):
        parse_printer(TEXT.replace("[axis.e]\nsteps_per_mm = 400.0", "[axis.e]\nsteps_per_mm = 0"), "mine.toml")


def test_a_deltas_arms_must_reach_its_centre():
    size = 'kinematics = "delta"\ndelta_radius = 140\narm_length = {}'
    good = parse_printer(TEXT.replace('kinematics = "cartesian"', size.format(300)), "mine.toml")
    assert (good.delta_radius, good.arm_length) == (140.0, 300.0)
    with pytest.raises(ProfileError, match="not longer than delta_radius = 140"):
        parse_printer(TEXT.replace('kinematics = "cartesian"', size.format(140)), "mine.toml")
