"""Duan 2015: the conventions that decide its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from fbfcli.papers import duan_2015
from fbfcli.papers.duan_2015_plant import DURATION, RATE, ZEROS, E, basis, desired, lti_error, plant, rms


@pytest.mark.parametrize("zero", ZEROS)
def test_the_plant_has_unit_gain_and_its_output_starts_with_its_input(zero):
    G, U = plant(zero), basis(20)
    assert G.b.sum() / G.a.sum() == pytest.approx(1)
    np.testing.assert_allclose(G.filtered(U)[0], U[0], atol=1e-12)


@pytest.mark.parametrize("axis", "xy")
def test_derivatives_of_the_path_are_those_of_its_samples(axis):
    for order in (1, 2):
        by_samples = np.gradient(desired(axis, order - 1), DURATION / E)
        exact = desired(axis, order)  # jerk jumps where moves meet
        assert np.quantile(np.abs(by_samples - exact), 0.97) < 2e-3 * np.abs(exact).max()


def test_npz_ignore_errs_by_the_step_and_zpetc_by_the_second_difference():
    """1 - L = -(a / (1 - a)) (1 - z^-1) and (a / (1 - a)^2) (z^-1 - 2 + z)."""
    y = desired("x")
    steps, bends = np.diff(y, prepend=y[0]), np.diff(np.pad(y, 1, mode="edge"), 2)
    for zero in ZEROS:
        made = plant(zero).inverses()
        np.testing.assert_allclose(lti_error(made["NPZ-ignore"], y), -zero / (1 - zero) * steps, atol=1e-12)
        np.testing.assert_allclose(lti_error(made["ZPETC"], y), zero / (1 - zero) ** 2 * bends, atol=1e-11)


def test_the_bandwidth_limit_is_the_square_root_of_two_and_not_3_decibel(monkeypatch):
    f = np.arange(0, RATE / 2, 0.1)
    L = plant(-1.1).inverses()["ZPETC"].L.response(2 * np.pi * f / RATE)
    assert duan_2015.bandwidth(f, L) == pytest.approx(1822.7, abs=0.05)
    monkeypatch.setattr(duan_2015, "MAGNITUDE", 10 ** (3 / 20))
    assert duan_2015.bandwidth(f, L) == pytest.approx(1819.7, abs=0.05)


def test_a_response_that_stays_within_has_the_whole_band():
    f = np.linspace(0, 5000, 11)
    assert duan_2015.bandwidth(f, np.ones(11)) == 5000
    assert duan_2015.bandwidth(f, np.exp(-1j * np.linspace(0, 1, 11))) == 4000  # a delay: 45 degrees at 0.785 rad


def test_rows_of_a_delay_have_its_response():
    H = np.eye(E + 1, k=-3)
    f, L = duan_2015.row_responses(H, 50.0)
    np.testing.assert_allclose(L[10], np.exp(-2j * np.pi * f / RATE * 3), atol=1e-12)


def test_root_mean_square():
    assert rms(np.array([3.0, -4.0, 0.0, 0.0])) == 2.5
