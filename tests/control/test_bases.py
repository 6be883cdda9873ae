"""Bases of finite trajectories: orthonormal where they say so, complete, and the functions they are named for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.fft import dct as fast_dct

from fbfcli.control.bases import block_pulses, dct, laguerre
from fbfcli.control.wavelets import filters, wavelets
from fbfcli.errors import ControlError

ORTHONORMAL = {"dct": dct, "block pulses": block_pulses, "wavelets": wavelets}


@pytest.mark.parametrize("name", ORTHONORMAL)
@given(M=st.integers(0, 130), part=st.floats(0, 1))
def test_columns_are_orthonormal_for_any_length_and_size(name, M, part):
    Phi = ORTHONORMAL[name](M, round(part * M))
    np.testing.assert_allclose(Phi.T @ Phi, np.eye(Phi.shape[1]), atol=1e-10)


def test_dct_is_the_transform():
    x = np.random.default_rng(1).standard_normal(37)
    np.testing.assert_allclose(dct(36, 36).T @ x, fast_dct(x, norm="ortho"), atol=1e-12)


def test_block_pulses_hold_the_mean_of_their_samples():
    Phi = block_pulses(10, 3)
    held = Phi @ (Phi.T @ np.arange(11.0))
    assert np.count_nonzero(np.diff(held)) == 3
    assert held[0] == pytest.approx(np.arange(11.0)[Phi[:, 0] > 0].mean())


def test_laguerre_functions_are_orthonormal_once_they_have_died_away():
    Phi = laguerre(600, 8, 0.8)
    np.testing.assert_allclose(Phi.T @ Phi, np.eye(9), atol=1e-9)
    np.testing.assert_allclose(Phi[:, 0], 0.6 * 0.8 ** np.arange(601), atol=1e-12)


def test_laguerre_with_pole_at_zero_is_a_delay_line():
    np.testing.assert_array_equal(laguerre(5, 5, 0.0), np.eye(6))


@pytest.mark.parametrize("name", ["db1", "db4", "sym8", "coif2"])
@pytest.mark.parametrize("M", [63, 64, 90])
def test_any_orthogonal_wavelet_makes_an_orthonormal_basis(name, M):
    Phi = wavelets(M, M, name)
    np.testing.assert_allclose(Phi.T @ Phi, np.eye(M + 1), atol=1e-9)


def test_the_filter_of_two_moments_is_in_every_textbook():
    root = np.sqrt(3)
    h = np.array([1 + root, 3 + root, 3 - root, 1 - root]) / (4 * np.sqrt(2))
    np.testing.assert_allclose(filters("db2")[0], h, atol=1e-12)


def test_a_few_wavelets_say_most_of_a_smooth_function():
    y = np.sin(2 * np.pi * np.arange(256) / 256)
    Phi = wavelets(255, 63)
    assert np.linalg.norm(y - Phi @ (Phi.T @ y)) < 1e-4 * np.linalg.norm(y)


def test_bad_questions_are_refused():
    for ask in (lambda: dct(9, 10), lambda: block_pulses(9, 10), lambda: wavelets(9, 10), lambda: laguerre(9, 3, 1.0),
                lambda: wavelets(9, 3, "db99"), lambda: wavelets(9, 3, "bior2.2")):  # fmt: skip
        with pytest.raises(ControlError):
            ask()
