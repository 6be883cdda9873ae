"""Regularised FBF: the best answer to the worst plant."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.control.bases import dct
from fbfcli.control.fbf import coefficients
from fbfcli.control.lifted import causal, markov
from fbfcli.control.regularised import regularised
from fbfcli.errors import ControlError

M = 60
PHI = dct(M, 30)
G = causal(markov(np.array([1.0, -1.3]), np.array([1.0, -0.5]), M))


def desired(seed):
    return np.random.default_rng(seed).standard_normal(M + 1)


def worst_error(gamma, y_d, delta):
    return np.linalg.norm(y_d - G @ PHI @ gamma) + delta * np.linalg.norm(PHI @ gamma)


@settings(max_examples=30)
@given(st.floats(1e-4, 2), st.integers(0, 2**32 - 1))
def test_no_other_command_has_a_smaller_worst_error(delta, seed):
    y_d, rng = desired(seed), np.random.default_rng(seed)
    found = regularised(PHI, G @ PHI, y_d, delta)
    assert found.worst == pytest.approx(worst_error(found.gamma, y_d, delta))
    for size in (1e-6, 1e-3, 1.0):
        for _ in range(5):
            other = found.gamma + size * rng.standard_normal(len(found.gamma))
            assert worst_error(other, y_d, delta) >= found.worst * (1 - 1e-12)
    assert worst_error(coefficients(G @ PHI, y_d), y_d, delta) >= found.worst * (1 - 1e-12)


@settings(max_examples=20)
@given(st.floats(1e-3, 0.2), st.integers(0, 2**32 - 1))
def test_the_worst_plant_gives_that_error_and_no_plant_a_larger_one(delta, seed):
    y_d, rng = desired(seed), np.random.default_rng(seed)
    found = regularised(PHI, G @ PHI, y_d, delta)
    u = PHI @ found.gamma
    e = y_d - G @ u
    worst = -delta * np.outer(e, u) / np.linalg.norm(e) / np.linalg.norm(u)
    assert np.linalg.norm(y_d - (G + worst) @ u) == pytest.approx(found.worst)
    D = rng.standard_normal((M + 1, M + 1))
    D *= delta / np.linalg.norm(D, 2)
    assert np.linalg.norm(y_d - (G + D) @ u) <= found.worst * (1 + 1e-12)


@settings(max_examples=20)
@given(st.floats(1e-3, 0.2), st.integers(0, 2**32 - 1))
def test_the_coupled_equations_hold(delta, seed):
    y_d = desired(seed)
    found = regularised(PHI, G @ PHI, y_d, delta)
    Phi_f, e = G @ PHI, y_d - G @ PHI @ found.gamma
    assert found.alpha * np.linalg.norm(PHI @ found.gamma) == pytest.approx(delta * np.linalg.norm(e), rel=1e-6)
    normal = Phi_f.T @ (Phi_f @ found.gamma) + found.alpha * PHI.T @ (PHI @ found.gamma)
    np.testing.assert_allclose(normal, Phi_f.T @ y_d, atol=1e-8)


def test_a_plant_that_is_known_is_plain_least_squares():
    y_d = desired(0)
    found = regularised(PHI, G @ PHI, y_d, 0.0)
    np.testing.assert_allclose(found.gamma, coefficients(G @ PHI, y_d), atol=1e-9)


def test_a_plant_that_is_not_known_at_all_is_not_moved():
    found = regularised(PHI, G @ PHI, desired(0), 100.0)
    assert not found.gamma.any() and np.isinf(found.alpha)


def test_bounds_and_bases_that_make_no_sense_are_refused():
    with pytest.raises(ControlError, match="not negative"):
        regularised(PHI, G @ PHI, desired(0), -1.0)
    twice = np.hstack((PHI, PHI[:, :1]))
    with pytest.raises(ControlError, match="dependent"):
        regularised(twice, G @ twice, desired(0), 0.1)
