"""The frequency that a shaper is made for is the best there is, and scales with the machine."""

import numpy as np
import pytest

from fbfcli.control.shapers import MAX_DAMPING
from fbfcli.plant.model import plant_of
from fbfcli.printer import ImpulseResponse, ModalModel, Mode
from fbfcli.verify.shaper_tuning import MadeFor, best, corner_error, klippers

DT = 1e-3
ONE = plant_of(ModalModel((Mode(40.0, 0.05),)), DT, "x")
TWO = plant_of(ModalModel((Mode(40.0, 0.05, 0.7), Mode(75.0, 0.05, 0.3))), DT, "x")


@pytest.mark.parametrize("plant", [ONE, TWO], ids=["one mode", "two modes"])
@pytest.mark.parametrize("name", list(MAX_DAMPING))
def test_no_other_frequency_leaves_less_of_a_corner(name, plant):
    found = best(name, plant)
    least = corner_error(name, found, plant)
    for frequency in np.linspace(30.0, 150.0, 25).tolist():
        assert least <= 1.001 * corner_error(name, MadeFor(frequency, found.damping), plant)


def test_zv_is_made_for_the_one_mode_there_is():
    assert best("zv", ONE).frequency == pytest.approx(40.0, rel=0.05)


@pytest.mark.parametrize("name", ["mzv", "ei", "3hump_ei"])
def test_a_machine_twice_as_fast_wants_twice_the_frequency(name):
    fast = plant_of(ModalModel((Mode(60.0, 0.05),)), DT, "x")
    slow = plant_of(ModalModel((Mode(30.0, 0.05),)), DT, "x")
    assert best(name, fast).frequency == pytest.approx(2 * best(name, slow).frequency, rel=0.05)


@pytest.mark.parametrize("name", ["zv", "mzv"])
def test_klippers_calibration_finds_about_the_mode(name):
    assert klippers(name, ONE).frequency == pytest.approx(40.0, rel=0.1)


def test_nothing_is_made_for_what_does_not_vibrate():
    rigid = plant_of(ImpulseResponse((1.0,), DT), DT, "x")
    assert best("zv", rigid) is None and klippers("zv", rigid) is None
