"""Dense FBF: projections, conditions kept, derivatives weighed, ranks revealed; a test per pitfall of conditioning."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.control.bases import dct, laguerre
from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.fbf import (
    coefficients,
    constrained,
    decoupled,
    decoupled_in_order,
    depends,
    filtered_from_rest,
    output_space,
    with_derivatives,
)
from fbfcli.control.lifted import bound, causal, decoupled_bound, markov, metric, observability
from fbfcli.errors import ControlError

M = 120
p = 0.5
y_d = np.random.default_rng(7).standard_normal(M + 1)


def plant(a: float) -> np.ndarray:
    return causal(markov(np.array([1.0, -a]), np.array([1.0, -p]), M))


@given(st.floats(-5, 5), st.integers(0, 100))
def test_error_is_what_the_filtered_functions_cannot_reach(a, n):
    Phi = dct(M, n)
    Phi_f = plant(a) @ Phi
    e = y_d - Phi_f @ coefficients(Phi_f, y_d)
    assert np.abs(Phi_f.T @ e).max() < 1e-7 * np.linalg.norm(Phi_f) * np.linalg.norm(y_d)


@given(st.floats(-5, 5), st.integers(0, 100), st.sampled_from(["dct", "splines"]))
def test_accuracy_does_not_depend_on_plant_or_basis(a, n, kind):
    """Ramani 2020 Prop. 2.1, with zeros on the unit circle and at zero among the examples."""
    Phi = dct(M, n) if kind == "dct" else bsplines(normalised_time(M), n, min(3, n))
    Q = output_space(plant(a) @ Phi)
    assert metric(np.eye(M + 1) - Q @ Q.T) == pytest.approx(np.sqrt(1 - (n + 1) / (M + 1)), rel=1e-9)


@pytest.mark.parametrize("a", [-1.0, 1.0, 1.1, -1.1, 0.0])
def test_the_controller_is_the_least_squares_command(a):
    Phi = dct(M, 60)
    fbf = decoupled(Phi, plant(a) @ Phi)
    expected = Phi @ coefficients(plant(a) @ Phi, y_d)
    np.testing.assert_allclose(fbf.command(y_d), expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(plant(a) @ fbf.Psi, fbf.Psi_f, atol=1e-9)
    np.testing.assert_allclose(fbf.L @ fbf.L, fbf.L, atol=1e-12)
    np.testing.assert_allclose(fbf.C @ y_d, fbf.command(y_d), atol=1e-9 * np.abs(expected).max())
    assert bound(fbf.C) <= decoupled_bound(fbf.Psi, fbf.Psi_f) * (1 + 1e-12)


def test_in_order_the_first_functions_are_a_smaller_controller():
    Phi = dct(M, 60)
    whole, part = decoupled_in_order(Phi, plant(2.0) @ Phi), decoupled(Phi[:, :20], plant(2.0) @ Phi[:, :20])
    np.testing.assert_allclose(whole.Psi[:, :20] @ whole.Psi_f[:, :20].T, part.C, atol=1e-9)


def test_in_order_refuses_functions_that_depend():
    Phi = bsplines(normalised_time(1000), 990, 5)
    with pytest.raises(ControlError, match="dependent"):
        decoupled_in_order(Phi, Phi)


def test_laguerre_functions_track_too():
    Phi = laguerre(M, 40, 0.7)
    fbf = decoupled(Phi, plant(1.1) @ Phi)
    np.testing.assert_allclose(
        fbf.output(Phi[:, 3]), plant(1.1) @ Phi @ coefficients(plant(1.1) @ Phi, Phi[:, 3]), atol=1e-9
    )


class TestConditioning:
    """n = 990 splines on M = 1000: condition 1e16, a few functions vanish in double precision."""

    Phi = bsplines(normalised_time(1000), 990, 5)
    G = causal(markov(np.array([1.0, -1.02]), np.array([1.0, -p]), 1000))
    y_d = np.random.default_rng(0).standard_normal(1001)

    def test_the_basis_is_beyond_double_precision(self):
        assert np.linalg.cond(self.Phi) > 1e15

    def test_the_rank_is_revealed_and_the_command_stays_in_its_metric(self):
        fbf = decoupled(self.Phi, self.G @ self.Phi)
        assert 985 <= fbf.Psi.shape[1] < 991
        J_c = np.linalg.norm(fbf.Psi) / np.sqrt(1001)
        assert J_c == pytest.approx(1.6527e8, rel=1e-3)

    def test_without_revealing_the_rank_the_command_explodes(self):
        Phi_f = self.G @ self.Phi
        Q, Omega = np.linalg.qr(Phi_f)
        careless = self.Phi @ np.linalg.solve(Omega, Q.T @ self.y_d)
        careful = self.Phi @ coefficients(Phi_f, self.y_d)
        assert np.linalg.norm(careless) > 1e3 * np.linalg.norm(careful)

    def test_normal_equations_give_a_wrong_metric(self):
        Phi_f = self.G @ self.Phi
        normal = Phi_f @ np.linalg.pinv(Phi_f.T @ Phi_f) @ Phi_f.T
        expected = np.sqrt(1 - 991 / 1001)
        assert metric(np.eye(1001) - normal) > 1.05 * expected
        Q = output_space(Phi_f)
        assert metric(np.eye(1001) - Q @ Q.T) == pytest.approx(expected, rel=1e-9)


def test_conditions_hold_exactly_and_the_rest_is_least_squares():
    m, n = 4, 30
    xi = normalised_time(M)
    Phi_f = plant(-1.1) @ bsplines(xi, n, m)
    Q = np.vstack([bsplines(xi[:1], n, m, r) for r in range(3)])
    z = np.array([1.5, -3.0, 40.0])
    gamma = constrained(Phi_f, y_d, Q, z)
    np.testing.assert_allclose(Q @ gamma, z, atol=1e-8)
    saddle = np.block([[Phi_f.T @ Phi_f, Q.T], [Q, np.zeros((3, 3))]])  # Duan 2015 Eq. 31 by its multipliers
    multipliers = np.linalg.solve(saddle, np.concatenate((Phi_f.T @ y_d, z)))[: n + 1]
    np.testing.assert_allclose(gamma, multipliers, atol=1e-6 * np.abs(multipliers).max())


def test_conditions_that_contradict_each_other_are_refused():
    with pytest.raises(ControlError, match="contradict"):
        constrained(np.eye(4), np.ones(4), np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0]]), np.array([0.0, 1.0]))


def test_weight_on_a_derivative_buys_its_accuracy():
    n, m, xi = 15, 4, normalised_time(M)
    target = np.sin(9 * xi) * xi**2
    slope = np.gradient(target, xi)
    N = [plant(-1.1) @ bsplines(xi, n, m, r) for r in range(2)]

    def errors(alpha):
        Phi_f, y = with_derivatives([(1.0, N[0], target), (alpha, N[1], slope)])
        gamma = coefficients(Phi_f, y)
        return np.linalg.norm(target - N[0] @ gamma), np.linalg.norm(slope - N[1] @ gamma)

    (position, velocity), (position_more, velocity_more) = errors(0.0), errors(0.1)
    assert velocity_more < velocity and position_more > position


def test_from_rest_a_function_starts_where_it_is():
    b, a = np.array([-5.0, 5.5]), np.array([1.0, -0.5])  # Duan 2015 Eq. 37, a = 1.1
    Phi = bsplines(normalised_time(50), 10, 4)
    np.testing.assert_allclose(filtered_from_rest(b, a, Phi)[0], Phi[0], atol=1e-12)
    np.testing.assert_allclose(filtered_from_rest(b, a, np.ones((50, 1))), 1, atol=1e-12)


@pytest.mark.parametrize(("n", "state", "expected"), [(50, 0.0, False), (100, 0.0, True), (100, 1e-3, False)])
def test_the_rank_test_of_app_c(n, state, expected):
    last, a = 100, 2.0
    K = (1 - p) / (1 - a)
    G = causal(markov(K * np.array([1.0, -a]), np.array([1.0, -p]), last))
    Gamma = observability(np.array([[p]]), np.array([[K * (p - a)]]), last)
    assert depends(dct(last, n), np.full((1, n + 1), state), G, Gamma) == expected
