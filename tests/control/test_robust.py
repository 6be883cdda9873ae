"""Robust filters: the paper's closed forms against their definitions, and what they are the best at."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize

from fbfcli.control.kernel_uncertainty import kernel_uncertainty
from fbfcli.control.robust import (
    first_order_filter,
    gain_modulation,
    robust_filter,
    worst_case_filter,
    worst_case_modulation,
)
from fbfcli.errors import ModelError

Z = np.exp(1j * np.linspace(0.05, np.pi - 0.05, 97))
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)

nominal = st.floats(0.05, 4) | st.floats(-4, -0.05)


def family(count=16):
    f = np.linspace(0, 60, 40)
    return np.array([1 / (1 - (f / (25 + 0.3 * i)) ** 2 + 0.1j * f / 25) for i in range(count)])


@given(nominal, st.floats(0, 2), st.floats(-0.9, 0.9))
def test_eq_13_is_eq_11_for_a_uniform_zero(a_nom, a_d, p):
    G = (Z - (a_nom + a_d * NODES)[:, None]) / (Z - p)
    b, a = first_order_filter(a_nom, a_d, p)
    np.testing.assert_allclose(np.polyval(b, Z) / np.polyval(a, Z), robust_filter(G, WEIGHTS / 2), rtol=5e-9)


@given(nominal, st.floats(1e-3, 5))
def test_proposition_1(a_nom, a_d):
    """Two real zeros, one inside and one outside the unit circle."""
    zeros = np.roots(first_order_filter(a_nom, a_d, 0.5)[0])
    assert not np.iscomplex(zeros).any()
    assert np.abs(zeros).min() < 1 < np.abs(zeros).max()
    assert np.prod(zeros) == pytest.approx(1)


@given(nominal, st.floats(0, 3))
def test_the_nominal_inverse_is_modulated_by_a_real_gain_of_one_or_more(a_nom, a_d):
    b, a = gain_modulation(a_nom, a_d)
    alpha = np.polyval(b, Z) / np.polyval(a, Z)
    assert np.abs(alpha.imag).max() < 1e-9 * np.abs(alpha).max()
    assert alpha.real.min() > 1 - 1e-9


def test_no_robust_filter_of_a_zero_at_the_origin():
    with pytest.raises(ModelError):
        first_order_filter(0.0, 0.1, 0.5)


@given(st.floats(0.2, 2), st.floats(0, 2), st.floats(-3, 3), st.floats(0, 2.5))
def test_no_controller_has_a_smaller_worst_error(r, wider, theta, turned):
    """Against every controller of a fine grid about the best one; |1 - C G| is convex in C."""
    bounds = (np.array([r]), np.array([r + wider])), (np.array([theta]), np.array([theta + turned]))
    G = np.outer(np.linspace(r, r + wider, 12), np.exp(1j * np.linspace(theta, theta + turned, 13))).ravel()
    best = 1 / worst_case_filter(*bounds)[0]
    worst = np.abs(1 - best * G).max()
    for step in (1e-4, 1e-2, 1.0):
        around = best + step * np.exp(2j * np.pi * np.arange(24) / 24)
        assert np.abs(1 - np.outer(around, G)).max(axis=1).min() >= worst - 1e-5 * step - 2e-3 * turned**2


def test_a_phase_that_may_be_anything_is_not_acted_on():
    bounds = (np.array([0.5]), np.array([2.0])), (np.array([0.0]), np.array([np.pi + 0.1]))
    assert np.isinf(np.abs(worst_case_filter(*bounds))).all()


def test_a_modulated_inversion_keeps_the_nominal_phase_and_is_the_best_that_does():
    r, theta, G_nom = (np.array([0.8]), np.array([1.3])), (np.array([-0.2]), np.array([0.4])), np.array([np.exp(0.05j)])
    G_r = worst_case_modulation(G_nom, r, theta)
    alpha = G_nom / G_r
    assert abs(alpha.imag[0]) < 1e-12
    G = np.outer(np.linspace(0.8, 1.3, 101), np.exp(1j * np.linspace(-0.2, 0.4, 121))).ravel() / G_nom
    found = minimize(lambda gain: np.abs(1 - gain[0] * G).max(), [0.5], method="Nelder-Mead", options={"xatol": 1e-9})
    assert alpha.real[0] == pytest.approx(found.x[0], abs=1e-6)


@pytest.mark.parametrize("k", [3, 17, 30])
def test_eq_19_is_its_integrals(k):
    known = kernel_uncertainty(family())
    (r_0, r_1), (t_0, t_1) = (tuple(end[k] for end in bound) for bound in known.bounds)

    def kernels(mean, sigma, x):
        return np.exp(-(((x - mean[:, k]) / sigma[k]) ** 2) / 2).sum()

    def f_1(r):
        return kernels(known.r, known.sigma_r, r)

    def f_2(t):
        return kernels(known.theta, known.sigma_theta, t)

    alpha = quad(lambda r: f_1(r) * r**3, r_0, r_1)[0] * quad(f_2, t_0, t_1)[0]
    turned = quad(lambda t: f_2(t) * np.cos(t), t_0, t_1)[0] - 1j * quad(lambda t: f_2(t) * np.sin(t), t_0, t_1)[0]
    beta = quad(lambda r: f_1(r) * r**2, r_0, r_1)[0] * turned
    assert known.robust_filter()[k] == pytest.approx(alpha / beta, rel=1e-9)


def test_responses_that_agree_are_their_own_robust_filter():
    G = np.repeat(family(1), 5, axis=0)
    np.testing.assert_allclose(kernel_uncertainty(G).robust_filter(), G[0], rtol=1e-6)


def test_realisations_stay_within_the_bounds_and_are_smooth():
    known = kernel_uncertainty(family())
    drawn = known.realisations(500, 0)
    (r_0, r_1), (t_0, t_1) = known.bounds
    theta = np.unwrap(np.angle(drawn), axis=1)
    assert np.all((np.abs(drawn) >= r_0 * (1 - 1e-9)) & (np.abs(drawn) <= r_1 * (1 + 1e-9)))
    assert np.all((theta >= t_0 - 1e-9) & (theta <= t_1 + 1e-9))
    np.testing.assert_allclose(np.abs(drawn).mean(axis=0), known.r.mean(axis=0), rtol=0.1)
    assert np.abs(np.diff(theta, axis=1)).max() < 1.5 * np.abs(np.diff(known.theta, axis=1)).max()
