"""Inverse methods on long trajectories: streams that follow the plant they are made for."""

from __future__ import annotations

import numpy as np
import pytest
from control_cases import DT, PLANTS, commanded, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.inverse_stream import INVERSION_METHODS, inverse
from fbfcli.errors import ModelError
from fbfcli.plant.model import impulse_response, modes

APPLICABLE = [(name, method) for name in PLANTS for method in INVERSION_METHODS
              if (name, method) not in {("hictop", "zmetc"), ("hictop", "ts"), ("hictop", "stable_inversion"),
                                        ("taz6", "ebzpetc")}]  # fmt: skip
MICRON = 1e-3


def axis(name):
    G = PLANTS[name]
    h = impulse_response(G)
    return AxisModel(G.b, G.a, h, tuple(modes(G)), (h,), np.ones(1))


def error_rms(name, u, y):
    """Of a command u, shape (n, 1), from where the plant should be [mm]."""
    G = PLANTS[name]
    e = lfilter(G.b, G.a, u[:, 0] - y[0, 0]) - (y[:, 0] - y[0, 0])
    return np.sqrt(np.mean(e**2))


def moved(compensator):
    """A motion with the rests that a compensator asks for, shape (1500, 1)."""
    return motion(0, 1500, 1, hold=max(compensator.lead, compensator.tail) + 2)


@pytest.mark.parametrize("method", INVERSION_METHODS)
@settings(max_examples=15)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=6), st.integers(0, 100))
def test_pieces_of_any_size_give_the_same_command(method, pieces, seed):
    compensator = inverse(method, [axis("35 Hz"), axis("28 Hz")], DT)
    y = motion(seed, 900, hold=60)
    whole = commanded(compensator, y)
    assert whole.shape == y.shape
    np.testing.assert_allclose(commanded(compensator, y, pieces), whole, atol=1e-11)
    np.testing.assert_array_equal(whole[[0, -1]], y[[0, -1]])
    np.testing.assert_allclose(whole[1], y[0], atol=1e-11)


@pytest.mark.parametrize(("name", "method"), APPLICABLE)
def test_taps_hold_a_position_and_die_out_within_the_holds(name, method):
    compensator = inverse(method, [axis(name)], DT)
    np.testing.assert_allclose(compensator.taps.sum(axis=1), 1, atol=1e-9)
    y = np.full((compensator.lead + compensator.tail + 50, 1), 37.0)
    np.testing.assert_allclose(commanded(compensator, y), y, atol=1e-10)


@pytest.mark.parametrize(("name", "method", "at_most"), [
    ("35 Hz", "zpetc", 0.1), ("35 Hz", "ebzpetc", 0.1), ("35 Hz", "ts", 0.1), ("35 Hz", "stable_inversion", 0.1),
    ("hictop", "zpetc", 0.1), ("hictop", "ebzpetc", 0.1), ("taz6", "stable_inversion", 0.04), ("taz6", "zpetc", 0.15),
    ("35 Hz", "npz_ignore", 0.6), ("taz6", "ts", 0.4)])  # fmt: skip
def test_errors_fall_to_a_part_of_the_uncompensated_ones(name, method, at_most):
    compensator = inverse(method, [axis(name)], DT)
    y = moved(compensator)
    assert error_rms(name, commanded(compensator, y), y) < at_most * error_rms(name, y, y)


def test_without_smoothing_an_inverse_is_as_good_as_its_metric():
    """A smooth motion is inverted to a tenth of a micron by stable inversion, to one by ZPETC."""
    for method, limit in (("stable_inversion", 0.2), ("zpetc", 2.0)):
        compensator = inverse(method, [axis("35 Hz")], DT, {"smooth": 0})
        y = moved(compensator)
        assert error_rms("35 Hz", commanded(compensator, y), y) < limit * MICRON


def test_a_gentler_command_goes_on_where_the_first_was():
    compensator = inverse("zpetc", [axis("35 Hz")], DT)
    gentler = compensator.stiffer()
    y = motion(3, 900, 1, hold=80)
    ones = np.ones(len(y))
    first = compensator.start(y[0])
    begun = first.push(y[:400], ones[:400], False)
    rest = gentler.resume(first).push(y[400:], ones[400:], True)
    whole = commanded(gentler, y)
    np.testing.assert_allclose(rest, whole[len(begun) :], atol=1e-12)
    sharp, smooth = (np.abs(np.diff(u[:, 0], 2)).max() for u in (commanded(compensator, y), whole))
    assert smooth < sharp
    levels = [compensator]
    while (harder := levels[-1].stiffer()) is not None:
        levels.append(harder)
    assert len({(each.lead, each.tail) for each in levels}) == 1


@pytest.mark.parametrize("method", ["zmetc", "ts", "stable_inversion"])
def test_a_plant_with_a_zero_on_the_unit_circle_is_refused_with_a_remedy(method):
    with pytest.raises(ModelError, match=r"unit circle, at -1; take .*lpfbs"):
        inverse(method, [axis("hictop")], DT)


def test_rests_on_the_published_models_are_those_of_the_documentation():
    for name, method, lead, tail in (("taz6", "zpetc", 0.03, 0.24), ("hictop", "zpetc", 0.03, 0.16),
                                     ("taz6", "stable_inversion", 0.21, 0.24)):  # fmt: skip
        compensator = inverse(method, [axis(name)], DT)
        assert compensator.lead * DT <= lead and 0.15 <= compensator.tail * DT <= tail


def test_smoothing_costs_13_um_at_5000_mm_per_s2():
    """(m + 1) / 24 (L dt)^2 y'' with m = 3, L dt = 4 ms, on a parabola."""
    compensator = inverse("stable_inversion", [axis("35 Hz")], DT)
    t = DT * np.arange(400)
    y = np.pad(2500 * t[:, None] ** 2, ((60, 0), (0, 0)))
    G = PLANTS["35 Hz"]
    e = lfilter(G.b, G.a, commanded(compensator, y)[:, 0]) - y[:, 0]
    at_printing_speed = slice(100, 120)  # 200 to 300 mm/s; what is cut off the response counts at higher speeds
    np.testing.assert_allclose(e[at_printing_speed], 5000 * 4 / 24 * 0.004**2, rtol=0.02)


def test_unknown_names_and_options_are_refused():
    bad = ("zpect", {}), ("ts", {"mu": 1.0}), ("ts", {"terms": 0.0}), ("ts", {"smooth": -1.0}), ("ts", {"preview": 0.0})
    for name, options in bad:
        with pytest.raises(ValueError, match=r"unknown|at least 1"):
            inverse(name, [axis("35 Hz")], DT, options)
