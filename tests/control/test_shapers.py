"""Shapers: what their impulses sum to, cancel and keep."""

from __future__ import annotations

from math import exp, pi, sqrt

import numpy as np
import pytest
from control_cases import DT, answering, commanded, described, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from fbfcli.control.axis_model import exactly
from fbfcli.control.design import design
from fbfcli.control.shapers import MAX_DAMPING, impulses
from fbfcli.errors import ModelError
from fbfcli.plant.model import impulse_response, modes, plant_of
from fbfcli.printer import ModalModel, Mode

NAMES = list(MAX_DAMPING)


def left_over(A, T, f, zeta):
    """Vibration after the last impulse, relative to one impulse at once."""
    w = 2 * pi * f
    return abs(np.sum(A * np.exp((zeta + 1j * sqrt(1 - zeta**2)) * w * (T - T[-1]))))


@given(st.sampled_from(NAMES), st.floats(15, 150), st.floats(0, 0.19))
def test_impulses_are_positive_ordered_and_sum_to_one(name, f, zeta):
    A, T = impulses(name, f, zeta)
    assert A.sum() == pytest.approx(1, abs=1e-12)
    assert np.all(A > 0) and T[0] == 0 and np.all(np.diff(T) > 0)


@given(st.sampled_from(["zv", "zvd"]), st.floats(15, 150), st.floats(0, 0.3))
def test_zero_vibration_shapers_leave_none(name, f, zeta):
    assert left_over(*impulses(name, f, zeta), f, zeta) < 1e-9


@pytest.mark.parametrize(("name", "left"), [("mzv", 0.02), ("ei", 0.055), ("2hump_ei", 0.055), ("3hump_ei", 0.055)])
@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.1])
def test_insensitive_shapers_leave_what_they_tolerate(name, left, zeta):
    assert left_over(*impulses(name, 50.0, zeta), 50.0, zeta) < left


def test_impulses_of_klipper_at_50_hz_and_a_tenth():
    K = exp(-0.1 * pi / sqrt(0.99))
    t_d = 0.02 / sqrt(0.99)
    A, T = impulses("zv", 50.0, 0.1)
    assert_allclose(A, [1 / (1 + K), K / (1 + K)])
    assert_allclose(T, [0, t_d / 2])
    A, T = impulses("mzv", 50.0, 0.1)
    raw = [1 - sqrt(0.5), (sqrt(2) - 1) * K**0.75, (1 - sqrt(0.5)) * K**1.5]
    assert_allclose(A, np.array(raw) / sum(raw))
    assert_allclose(T, [0, 0.375 * t_d, 0.75 * t_d])
    A, T = impulses("ei", 50.0, 0.1)
    assert_allclose(A, [0.35488, 0.45300, 0.19212], atol=1e-5)  # Klipper's polynomials, worked out by hand
    assert_allclose(T, [0, 0.504698 * t_d, t_d], rtol=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_mean_delay_is_zero(name):
    compensator = design(name, *described("35 Hz", "45+85 Hz"))
    k = np.arange(compensator.taps.shape[1]) - compensator.lead
    assert_allclose(compensator.taps.sum(axis=1), 1, atol=1e-12)
    assert_allclose(compensator.taps @ k, 0, atol=1e-9)


@pytest.mark.parametrize("f", [28.0, 35.0, 52.3])
def test_zv_leaves_no_vibration_of_its_own_plant(f):
    plant = plant_of(ModalModel((Mode(f, 0.05),)), DT, "x")
    h = impulse_response(plant)
    zv = design("zv", [exactly(plant.b, plant.a, h, modes(plant))], DT)
    y = np.concatenate((np.zeros(100), np.ones(900)))[:, None] * np.ones(1)
    y = np.cumsum(np.convolve(y[:, 0], np.ones(5) / 5, "same"))[:, None]
    y[950:] = y[950]
    still, shaped = y[:, 0], commanded(zv, y)[:, 0]
    ringing = [np.ptp((np.convolve(u, h)[: len(u)] - u)[300:600]) for u in (still, shaped)]
    assert ringing[1] < 0.02 * ringing[0]


@given(
    name=st.sampled_from(["none", *NAMES]),
    seed=st.integers(0, 10**6),
    samples=st.integers(1, 800),
    pieces=st.lists(st.integers(1, 300), min_size=1, max_size=5),
)
@settings(max_examples=60, deadline=None)
def test_pieces_of_any_size_give_the_same_bits(name, seed, samples, pieces):
    compensator = design(name, *described("35 Hz", "28 Hz"))
    y = motion(seed, samples, hold=max(compensator.lead, compensator.tail))
    whole = commanded(compensator, y)
    assert whole.shape == y.shape
    assert_array_equal(commanded(compensator, y, pieces), whole)
    assert_array_equal(whole[[0, -1]], y[[0, -1]])
    assert np.all(whole >= y.min(axis=0) - 1e-9) and np.all(whole <= y.max(axis=0) + 1e-9)


def test_damping_beyond_a_shaper_is_refused():
    with pytest.raises(ModelError, match=r"at most 0\.2, the mode has 0\.25"):
        impulses("3hump_ei", 40.0, 0.25)


def test_a_model_without_modes_needs_a_frequency():
    with pytest.raises(ModelError, match="oscillating"):
        design("zv", [answering(np.ones(1))], DT)
    assert design("zv", [answering(np.ones(1))], DT, {"frequency": 40.0, "damping": 0.1}).name == "zv"
