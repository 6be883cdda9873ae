"""The banded solution is the least-squares solution, whatever the stretch."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from control_cases import DT, PLANTS, answering, commanded, described, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import lstsq
from scipy.signal import lfilter

from fbfcli.control.basis import uniform_basis
from fbfcli.control.design import design
from fbfcli.errors import ModelError
from fbfcli.plant.model import impulse_response


def dense_full_preview(h, y, m, L, mu):
    """u minimising the error to infinity after the end, by rank-revealing least squares on the whole lifted system."""
    beta = uniform_basis(m, L).beta
    psi, bent = np.convolve(h, beta), np.convolve(beta, [1, -2, 1])
    N, n = len(y), (len(y) - 1) // L - m
    rows, columns = N + len(psi), (N + len(psi)) // L + 1

    def lifted(one):
        matrix = np.zeros((rows + len(one), columns))
        for i in range(columns):
            matrix[i * L : i * L + len(one), i] = one
        return matrix[:rows]

    Phi, bend, splines = lifted(psi), lifted(bent), lifted(beta)
    end = y[-1] - y[0]
    later = np.full(columns - n, end)
    target = np.concatenate((y - y[0], np.full(rows - N, end))) - Phi[:, n:] @ later
    reach = (n + m + 1) * L + 2  # no free spline bends the command later
    A = np.vstack((Phi[:, :n], np.sqrt(mu) * bend[:reach, :n]))
    gamma = lstsq(A, np.concatenate((target, -np.sqrt(mu) * bend[:reach, n:] @ later)), lapack_driver="gelsy")[0]
    return y[0] + splines[:N] @ np.concatenate((gamma, later))


@pytest.mark.parametrize("name", ["taz6", "hictop", "35 Hz", "45+85 Hz"])
@pytest.mark.parametrize(("L", "mu", "m"), [(4, 10.0, 5), (6, 1.0, 5), (8, 0.0, 5), (17, 0.0, 5), (6, 10.0, 3)])
def test_agrees_with_dense_least_squares(name, L, mu, m):
    axes, dt = described(name)
    compensator = design("fbf", axes, dt, {"L": L, "mu": mu, "degree": m})
    for seed, samples in enumerate((150, 231, 402)):
        y = motion(seed, samples, 1)
        assert_allclose(commanded(compensator, y)[:, 0], dense_full_preview(axes[0].h, y[:, 0], m, L, mu), atol=1e-9)


def test_windows_of_a_long_stretch_agree_with_one_piece():
    axes, dt = described("taz6", "28 Hz")
    y = motion(3, 8000)
    whole = commanded(design("fbf", axes, dt), y)
    needed = design("fbf", axes, dt)
    preview = needed.n_c - needed.n_up
    windowed = design("fbf", axes, dt, {"n_C": preview + 150, "n_up": 150})
    assert_allclose(commanded(windowed, y), whole, atol=1e-9)
    assert_allclose(commanded(windowed, y, [1, 700, 3]), whole, atol=1e-9)


@given(seed=st.integers(0, 10**6), samples=st.integers(1, 700))
@settings(max_examples=40, deadline=None)
def test_command_rests_at_both_ends_exactly(seed, samples):
    y = motion(seed, samples)
    compensator = design("fbf", *described("35 Hz", "28 Hz"), {"L": 4})
    u = commanded(compensator, y)
    assert u.shape == y.shape
    assert_array_equal(u[0], y[0])
    assert_array_equal(u[-1], y[-1])
    if samples > compensator.settle:
        step = np.abs(np.diff(y, axis=0)).max() + 1e-9
        assert np.all(np.abs(u[1] - y[0]) < step) and np.all(np.abs(u[-2] - y[-1]) < step)


@given(st.integers(0, 10**6), st.floats(-200, 200), st.floats(-3, 3))
@settings(max_examples=25, deadline=None)
def test_command_is_linear_and_moves_with_the_origin(seed, shift, factor):
    compensator = design("fbf", *described("taz6", "35 Hz"))
    y, z = motion(seed, 500, offset=0.0), motion(seed + 1, 500, offset=0.0)
    u, v = commanded(compensator, y), commanded(compensator, z)
    assert_allclose(commanded(compensator, y + shift), u + shift, atol=1e-8)
    assert_allclose(commanded(compensator, y + factor * z), u + factor * v, atol=1e-8)


def test_error_falls_as_control_points_double():
    y = motion(1, 2000, 1, hold=60)
    axes, dt = described("35 Hz")
    plant = PLANTS["35 Hz"]

    def error(L):
        u = commanded(design("fbf", axes, dt, {"L": L, "mu": 0.0}), y)[:, 0]
        return np.sqrt(np.mean((lfilter(plant.b, plant.a, u - u[0]) + u[0] - y[:, 0]) ** 2))

    errors = [error(L) for L in (32, 16, 8, 4)]
    assert all(finer < coarser / 2 for coarser, finer in pairwise(errors)), errors


@pytest.mark.parametrize("name", list(PLANTS))
def test_output_follows_within_a_few_micrometres_and_the_command_stays_tame(name):
    compensator = design("fbf", *described(name))
    y = motion(5, 3000, 1, hold=compensator.lead)
    u = commanded(compensator, y)
    plant = PLANTS[name]
    error = lfilter(plant.b, plant.a, u[:, 0] - u[0]) + u[0] - y[:, 0]
    assert np.sqrt(np.mean(error**2)) < 0.010
    assert np.abs(np.diff(u, 2, axis=0)).max() < 2.5 * np.abs(np.diff(y, 2, axis=0)).max()


def test_an_unscaled_model_costs_what_scaling_saves():
    """A model whose gain at 0 Hz is 1.001 is wrong by 1 um per mm."""
    y = motion(7, 2000, 1, offset=0.0)
    plant = PLANTS["35 Hz"]
    h = impulse_response(plant)
    errors = []
    for scale in (1.0, 1.001):
        u = commanded(design("fbf", [answering(scale * h)], DT, {"L": 6, "mu": 0.0}), y)[:, 0]
        errors.append(np.abs(lfilter(plant.b, plant.a, u) - y[:, 0]).max())
    assert errors[1] > errors[0] + 5e-4 * np.abs(y).max()


def test_splines_that_the_plant_hides_are_refused():
    h = np.ones(1)
    for _ in range(8):  # eightfold zeros at every eighth of the sampling rate
        h = np.convolve(h, np.ones(8) / 8)
    with pytest.raises(ModelError, match="hides"):
        design("fbf", [answering(h)], DT, {"L": 1, "mu": 0.0})
