"""Splines: a partition of unity by the recursion of the papers, with derivatives that are slopes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.control.bspline import bsplines, clamped_knots, normalised_time, nurbs
from fbfcli.errors import ControlError

degrees = st.integers(0, 5)


def cox_de_boor(xi, eta, i, m):
    """Ramani 2020 Eq. F.2 as it is written, half-open intervals, the last point closed."""
    if m == 0:
        last = xi == 1 and eta[i] < 1 == eta[i + 1]
        return float(eta[i] <= xi < eta[i + 1] or last)
    left, right = eta[i + m] - eta[i], eta[i + m + 1] - eta[i + 1]
    a = (xi - eta[i]) / left * cox_de_boor(xi, eta, i, m - 1) if left else 0.0
    b = (eta[i + m + 1] - xi) / right * cox_de_boor(xi, eta, i + 1, m - 1) if right else 0.0
    return a + b


@given(degrees, st.integers(0, 8), st.integers(1, 25))
def test_the_recursion_of_the_papers(m, more, M):
    n = m + more
    eta = clamped_knots(n, m)
    expected = [[cox_de_boor(xi, eta, i, m) for i in range(n + 1)] for xi in normalised_time(M)]
    np.testing.assert_allclose(bsplines(normalised_time(M), n, m), expected, atol=1e-12)


@given(degrees, st.integers(0, 40), st.integers(1, 200))
def test_they_sum_to_one_and_end_at_one(m, more, M):
    N = bsplines(normalised_time(M), m + more, m)
    np.testing.assert_allclose(N.sum(axis=1), 1, atol=1e-12)
    assert N.min() >= 0
    assert N[0, 0] == pytest.approx(1) and N[-1, -1] == pytest.approx(1)


def test_a_knot_inside_belongs_to_the_interval_after_it():
    """Closed at both ends (as Eq. F.2 is printed) a constant piece would be counted twice at every knot."""
    N = bsplines(np.array([0.0, 0.25, 0.5, 1.0]), 3, 0)
    assert N.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("weighted", [False, True])
def test_derivatives_are_slopes(order, weighted):
    m, n, h = 5, 11, 1e-5
    w = np.linspace(0.5, 2, n + 1) if weighted else np.ones(n + 1)
    xi = np.linspace(0.021, 0.979, 97)
    slope = (nurbs(xi + h, m, w, order - 1) - nurbs(xi - h, m, w, order - 1)) / (2 * h)
    exact = nurbs(xi, m, w, order)
    np.testing.assert_allclose(exact, slope, atol=1e-5 * np.abs(exact).max())


def test_first_slope_is_that_of_duan_2015_eq_29():
    """c'(0) = m w_1 / w_0 (p_1 - p_0) (n - m + 1): the knots' spacing, which the paper leaves to T."""
    m, w = 4, np.array([1.0, 2.0, 1.0, 3.0, 1.0, 1.0, 2.0])
    slope = nurbs(np.array([0.0]), m, w, 1)[0]
    assert slope[1] == pytest.approx(m * w[1] / w[0] * (len(w) - m))
    assert slope[0] == pytest.approx(-slope[1])


def test_equal_weights_are_plain_splines():
    xi = normalised_time(50)
    np.testing.assert_allclose(nurbs(xi, 4, np.full(9, 3.0), 2), bsplines(xi, 8, 4, 2), atol=1e-9)


def test_a_derivative_beyond_the_degree_is_zero():
    assert not bsplines(normalised_time(20), 6, 2, 3).any()


def test_bad_questions_are_refused():
    with pytest.raises(ControlError, match="degree 5 need at least 6"):
        clamped_knots(4, 5)
    with pytest.raises(ControlError, match="positive"):
        nurbs(normalised_time(9), 2, np.array([1.0, 0, 1, 1]))
