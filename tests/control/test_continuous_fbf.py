"""FBF in continuous time: exact filtering, orthonormal functions, and the limit of the sampled form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.continuous_fbf import continuous_basis
from fbfcli.control.fbf import coefficients
from fbfcli.errors import ControlError

w, zeta, zero = 40.0, 0.05, 300.0  # a mode [1/s] and a zero in the right half plane
PLANT = (
    np.array([[0, 1], [-(w**2), -2 * zeta * w]]),
    np.array([[0.0], [1.0]]),
    w**2 * np.array([[1, -1 / zero]]),
    np.zeros((1, 1)),
)
T, m = 1.0, 4


def smooth(t: np.ndarray) -> np.ndarray:
    return t**3 * (10 - 15 * t + 6 * t**2)


def test_functions_are_filtered_as_a_simulation_does():
    basis = continuous_basis(PLANT, T, 12, m)
    t = np.linspace(0, T, 20001)
    for i in (0, 5, 12):
        _, y, _ = lsim(PLANT, bsplines(t, 12, m)[:, i], t)
        np.testing.assert_allclose(basis.y[:, i], np.interp(basis.t, t, y), atol=2e-5)


def test_functions_are_orthonormal_over_time():
    basis = continuous_basis(PLANT, T, 30, m)
    np.testing.assert_allclose(basis.Psi.T @ (basis.weights[:, None] * basis.Psi), np.eye(31), atol=1e-12)
    np.testing.assert_allclose(basis.Psi @ basis.Omega, basis.y, atol=1e-12)
    assert basis.weights.sum() == pytest.approx(T)


def test_coefficients_are_the_limit_of_the_sampled_ones():
    basis = continuous_basis(PLANT, T, 12, m)
    gamma = basis.coefficients(smooth(basis.t))
    apart = []
    for M in (500, 2000):
        Phi = bsplines(normalised_time(M), 12, m)
        t = np.linspace(0, T, M + 1)
        Phi_f = np.stack([lsim(PLANT, Phi[:, i], t)[1] for i in range(13)], axis=1)
        apart.append(np.abs(coefficients(Phi_f, smooth(t)) - gamma).max())
    assert apart[1] < 0.3 * apart[0] < 0.3


def test_error_falls_with_more_functions():
    errors = [(b := continuous_basis(PLANT, T, n, m)).error(smooth(b.t)) for n in (8, 16, 32)]
    assert errors[2] < errors[1] < errors[0] < 0.05


def test_one_input_and_one_output():
    with pytest.raises(ControlError, match="one input"):
        continuous_basis((PLANT[0], np.eye(2), PLANT[2], np.zeros((1, 2))), T, 12, m)
