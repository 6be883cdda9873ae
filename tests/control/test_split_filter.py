"""Filtering with unstable poles: bounded, two-sided, and the same as the transfer function."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from fbfcli.control.robust import first_order_filter
from fbfcli.control.split_filter import PERTURBED, split_filter
from fbfcli.errors import ModelError

N, MIDDLE = 1200, 600

real_poles = st.lists(st.sampled_from([0.3, -0.7, 0.9, 1.1, -1.3, 2.5]), min_size=1, max_size=4, unique=True)
zeros = st.lists(st.floats(-2, 2), max_size=5)


def impulse():
    x = np.zeros(N)
    x[MIDDLE] = 1.0
    return x


@given(real_poles, zeros, st.integers(-3, 3))
def test_it_has_the_frequency_response_of_the_transfer_function(p, z, ahead):
    b, a = np.atleast_1d(np.poly(z)), np.poly(p)
    omega = np.linspace(0, np.pi, 64)
    q = np.exp(-1j * omega)
    expected = q**-ahead * np.polyval(b[::-1], q) / np.polyval(a[::-1], q)
    H = split_filter(b, a, ahead)
    scale = np.abs(expected).max() + 1e-9
    assert np.abs(H.impulse_response().response(omega) - expected).max() < 1e-8 * scale
    y = H.filtered(impulse())
    found = np.exp(-1j * np.outer(omega, np.arange(N) - MIDDLE)) @ y
    assert np.abs(found - expected).max() < 1e-8 * scale


@given(st.floats(-0.95, 0.95), zeros, st.integers(0, 2**32 - 1))
def test_a_stable_filter_is_the_usual_recursion(p, z, seed):
    b, a = np.atleast_1d(np.poly(z)), np.array([1.0, -p])
    x = np.random.default_rng(seed).standard_normal((200, 2))
    expected = lfilter(b, a, x, axis=0)
    np.testing.assert_allclose(split_filter(b, a).filtered(x), expected, atol=1e-9 * np.abs(expected).max())


@given(st.floats(1.05, 4) | st.floats(-4, -1.05), st.integers(0, 2**32 - 1))
def test_an_unstable_filter_undoes_the_zero_that_it_came_from(a, seed):
    """1 / (1 - a z^-1) backward in time, then 1 - a z^-1, gives the signal back where nothing is cut off."""
    x = np.zeros(400)
    x[150:250] = np.random.default_rng(seed).standard_normal(100)
    y = split_filter([1.0], [1.0, -a]).filtered(np.pad(x, 400))
    assert np.abs(y).max() < 2 * np.abs(x).sum()
    np.testing.assert_allclose(lfilter([1.0, -a], [1.0], y)[400:800], x, atol=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_poles_on_the_unit_circle_are_moved_off_it(sign):
    """Ramani 2020b App. A: for |a_nom| = 1 as if it were 0.999, whose pole is outside."""
    H = split_filter([1.0], [1.0, -float(sign)])
    assert H.a_u == pytest.approx([1, -sign / PERTURBED])
    assert np.abs(H.filtered(impulse())).max() < 2


def test_the_robust_filter_of_a_minimum_phase_plant_is_run_backward():
    """Eq. 13 for a_nom = 0.9: pole 1 / 0.9."""
    H = split_filter(*first_order_filter(0.9, 0.1, 0.5))
    y = H.filtered(impulse())
    assert len(H.a_u) == len(H.a_s) == 2
    assert np.abs(y[:300]).max() < 1e-12 and np.abs(y[900:]).max() < 1e-12


def test_a_pole_that_rings_for_ever_is_refused():
    with pytest.raises(ModelError, match="rings"):
        split_filter([1.0], [1.0, -(1 - 2e-6)]).impulse_response()
