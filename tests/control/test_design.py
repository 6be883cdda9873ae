"""The registry and its default rules."""

from __future__ import annotations

import numpy as np
import pytest
from control_cases import DT, commanded, described, motion
from numpy.testing import assert_allclose, assert_array_equal

from fbfcli.control.basis import uniform_basis
from fbfcli.control.design import METHODS, design
from fbfcli.control.spline_design import curvature_weight, knot_spacing
from fbfcli.errors import ModelError

NOT_APPLICABLE = {  # inverses, by the zeros of a plant: docs/methods.md
    "taz6": {"ebzpetc"},
    "hictop": {"zmetc", "ts", "stable_inversion"},
    "35 Hz": set(),
}


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("plants", [("taz6", "taz6"), ("35 Hz", "28 Hz"), ("hictop", "45+85 Hz")])
def test_every_method_works_by_default_and_keeps_a_rest(name, plants):
    if name in NOT_APPLICABLE[plants[0]]:
        with pytest.raises(ModelError, match=name):
            design(name, *described(*plants))
        return
    compensator = design(name, *described(*plants))
    assert compensator.name == name
    rest = np.full((300, 2), 12.3)
    assert_array_equal(commanded(compensator, rest), rest)
    y = motion(0, 1200, hold=max(compensator.lead, compensator.tail))
    u = commanded(compensator, y)
    assert u.shape == y.shape and np.isfinite(u).all()


@pytest.mark.parametrize("name", ["lpfbs", "fbf"])
def test_nothing_but_a_rest_is_passed_through_if_too_short(name):
    compensator = design(name, *described("35 Hz"))
    y = motion(0, compensator.settle - 1, 1, hold=0)
    assert_allclose(commanded(compensator, y), y, atol=1e-12)


def test_knots_follow_the_fastest_mode_up_to_four_milliseconds():
    assert knot_spacing([((100.0, 0.05, 1.0),), ((30.0, 0.05, 1.0),)], DT) == 3
    assert knot_spacing([((20.0, 0.05, 1.0),)], DT) == 4
    assert knot_spacing([((400.0, 0.05, 1.0),)], DT) == 2
    assert knot_spacing([((60.0, 0.05, 1.0),)], DT / 2) == 8


def test_curvature_weight_is_physical():
    """The same at any period: mu counts second differences per sample, so it grows with dt^-4."""
    axis = ((28.0, 0.05, 1.0),)
    assert curvature_weight(axis, DT) == pytest.approx(2.11, rel=0.01)
    assert curvature_weight(axis, DT / 2) == pytest.approx(16 * curvature_weight(axis, DT))


def test_names_and_options_that_are_unknown_are_told():
    with pytest.raises(ValueError, match="zvv"):
        design("zvv", *described("35 Hz"))
    with pytest.raises(ValueError, match="knots"):
        design("fbf", *described("35 Hz"), {"knots": 4})


@pytest.mark.parametrize("name", METHODS)
def test_a_stretch_may_end_without_a_further_sample(name):
    compensator = design(name, *described("35 Hz", "28 Hz"))
    y = motion(1, 900, hold=60)
    stream = compensator.start(y[0])
    u = [stream.push(y, np.ones(len(y)), False), stream.push(y[:0], np.ones(0), True)]
    assert_allclose(np.concatenate(u), commanded(compensator, y), atol=1e-12)


@pytest.mark.parametrize("options", [{"L": 0}, {"degree": 0}, {"n_C": 20, "n_up": 21}, {"n_up": 0}])
@pytest.mark.parametrize("name", ["lpfbs", "fbf", "robust", "contour"])
def test_windows_that_make_no_sense_are_refused(name, options):
    with pytest.raises(ModelError):
        design(name, *described("35 Hz", "28 Hz"), options)


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("L", [1, 2, 7, 17])
def test_splines_sum_to_one_and_reproduce_lines(m, L):
    basis = uniform_basis(m, L)
    u = np.zeros(20 * L)
    basis.command(np.ones(20 + m), u)
    assert_allclose(u, 1, atol=1e-14)
    basis.command(np.arange(20.0 + m), u)
    assert_allclose(np.diff(u), 1 / L, atol=1e-12)
