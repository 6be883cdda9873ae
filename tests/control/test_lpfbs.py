"""Limited preview: the paper's windows, in pieces of any size, close to full preview, and refused where unstable."""

from __future__ import annotations

import numpy as np
import pytest
from control_cases import DT, commanded, described, family, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import lstsq, pinv

from fbfcli.control.basis import uniform_basis
from fbfcli.control.design import design
from fbfcli.control.lpfbs import limited_preview
from fbfcli.control.robust_basis import robust_response
from fbfcli.control.spline_fbf import filtered_basis
from fbfcli.errors import ModelError

PAPER = {"degree": 5, "L": 17, "n_C": 56, "n_up": 28, "mu": 0.0}  # Ramani 2020b, section V


def dense_windows(h, y, m, L, n_C, n_up, mu, windows):
    """Coefficients of the first windows by Eq. 24, each a dense rank-revealing least squares on its own samples."""
    beta = uniform_basis(m, L).beta
    psi, bent = np.convolve(h, beta), np.convolve(beta, [1, -2, 1])

    def lifted(one, columns):
        matrix = np.zeros((columns * L + len(one), columns))
        for i in range(columns):
            matrix[i * L : i * L + len(one), i] = one
        return matrix

    gamma = np.zeros(0)
    for k in range(windows):
        p = k * n_up
        rows = slice(p * L, (p + n_C) * L)
        A = np.vstack((lifted(psi, p + n_C)[rows], np.sqrt(mu) * lifted(bent, p + n_C)[rows]))
        target = np.concatenate((y[rows] - y[0], np.zeros(n_C * L))) - A[:, :p] @ gamma
        scale = np.linalg.norm(A[:, p:], axis=0)
        gamma_C = lstsq(A[:, p:] / scale, target, lapack_driver="gelsy")[0] / scale
        gamma = np.concatenate((gamma, gamma_C[:n_up]))
    return gamma


@pytest.mark.parametrize("name", ["taz6", "35 Hz"])
@pytest.mark.parametrize(("L", "n_C", "n_up", "mu"), [(17, 56, 28, 0.0), (8, 64, 24, 5.0), (6, 90, 40, 10.0)])
def test_agrees_with_dense_windows(name, L, n_C, n_up, mu):
    axes, dt = described(name)
    compensator = design("lpfbs", axes, dt, {"L": L, "n_C": n_C, "n_up": n_up, "mu": mu})
    y = motion(0, (n_C + 4 * n_up) * L, 1)
    gamma = dense_windows(axes[0].h, y[:, 0], 5, L, n_C, n_up, mu, 3)
    basis = uniform_basis(5, L)
    u = np.zeros(3 * n_up * L)
    basis.command(np.concatenate((np.zeros(5), gamma)), u)
    assert_allclose(commanded(compensator, y)[: len(u), 0], y[0, 0] + u, atol=1e-9)


@pytest.mark.parametrize(("name", "L", "n_C", "n_up", "mu"),
                         [("taz6", 8, 70, 30, 5.0), ("taz6", 17, 40, 7, 0.0), ("robust", 8, 70, 30, 5.0),
                          ("robust", 6, 20, 20, 1.0), ("35 Hz", 2, 60, 20, 50.0)])  # fmt: skip
def test_a_windows_matrices_are_the_pseudo_inverses(name, L, n_C, n_up, mu):
    """W is Phi_C^+ and V is Phi_C^+ Phi_PC, of samples above and of bending below; W undoes Phi_C where mu is 0."""
    h = robust_response(family(40.0, 0.08, 0.15, 5))[0] if name == "robust" else described(name)[0][0].h
    basis = uniform_basis(5, L)
    window = limited_preview(filtered_basis(basis, (h,), np.ones(1), mu, n_C), mu, n_C, n_up)
    lifted = []
    for one in (np.convolve(h, basis.beta), np.sqrt(mu) * np.convolve(basis.beta, [1, -2, 1])):
        k = np.arange(n_C * L)[:, None] - L * np.arange(-window.reach, n_C)
        lifted.append(np.where((k >= 0) & (k < len(one)), one[np.clip(k, 0, len(one) - 1)], 0.0))
    both = np.vstack(lifted)
    Phi, Phi_P = both[:, window.reach :], both[:, : window.reach]
    scale = np.linalg.norm(Phi, axis=0)
    inverse = (pinv(Phi / scale, rtol=1e-15) / scale[:, None])[:n_up]
    assert_allclose(window.W, inverse[:, : n_C * L], atol=1e-9)
    assert_allclose(window.V, inverse @ Phi_P, atol=1e-9)
    if mu == 0:
        assert_allclose(window.W @ Phi[: n_C * L], np.eye(n_up, n_C), atol=1e-9)


@given(
    seed=st.integers(0, 10**6),
    samples=st.integers(1, 3000),
    pieces=st.lists(st.integers(1, 900), min_size=1, max_size=6),
    method=st.sampled_from(["lpfbs", "fbf"]),
)
@settings(max_examples=40, deadline=None)
def test_pieces_of_any_size_give_the_same(seed, samples, pieces, method):
    compensator = design(method, *described("hictop", "28 Hz"))
    y = motion(seed, samples)
    whole, parts = commanded(compensator, y), commanded(compensator, y, pieces)
    assert_allclose(parts, whole, atol=1e-9)
    assert_array_equal(whole[[0, -1]], y[[0, -1]])


@pytest.mark.parametrize("name", ["taz6", "hictop", "35 Hz"])
def test_approaches_full_preview_as_the_preview_grows(name):
    axes, dt = described(name)
    y = motion(2, 6000, 1)
    full = commanded(design("fbf", axes, dt, {"L": 6}), y)
    gaps = [
        np.abs(commanded(design("lpfbs", axes, dt, {"L": 6, "n_C": 2 * n, "n_up": n}), y) - full).max()
        for n in (20, 42, 84)
    ]
    assert gaps[1] < 2e-5 and gaps[2] < 1e-6 and gaps[2] - 1e-9 <= gaps[1] <= gaps[0]


def test_the_papers_windows_are_close_to_full_preview():
    axes, dt = described("taz6")
    y = motion(4, 8000, 1)
    full = commanded(design("fbf", axes, dt, {"L": 17, "mu": 0.0}), y)
    assert_allclose(commanded(design("lpfbs", axes, dt, PAPER), y), full, atol=5e-6 * np.ptp(y))


def test_an_unstable_recursion_is_refused_with_its_radius():
    with pytest.raises(ModelError, match=r"amplify their errors (6[5-9]|7[0-3])"):
        design("lpfbs", *described("taz6"), {**PAPER, "L": 4})


def test_knots_at_every_sample_are_refused():
    with pytest.raises(ModelError, match="knots every 1 samples are too near"):
        design("lpfbs", *described("35 Hz"), {"L": 1})


@given(st.floats(1, 300), st.floats(-100, 100))
@settings(max_examples=20, deadline=None)
def test_a_straight_line_at_constant_speed_survives(speed, start):
    """The middle of a long line is the line itself, ahead by the plant's mean delay."""
    axes, dt = described("taz6", "35 Hz")
    n = 4000
    k = np.arange(n)
    s = np.interp(k, [0, 100, n - 100, n], [0, 0, n - 200, n - 200]) * speed * DT
    u = commanded(design("lpfbs", axes, dt), np.column_stack((start + s, start - s)))
    middle = slice(1500, 2500)
    for axis, sign in enumerate((1, -1)):
        delay = np.arange(len(axes[axis].h)) @ axes[axis].h * DT
        expected = start + sign * (s[middle] + speed * delay)
        assert_allclose(u[middle, axis], expected, atol=1e-5 * speed)


@given(st.integers(0, 10**6), st.floats(-200, 200), st.floats(-3, 3))
@settings(max_examples=20, deadline=None)
def test_command_is_linear_and_moves_with_the_origin(seed, shift, factor):
    compensator = design("lpfbs", *described("taz6", "35 Hz"))
    y, z = motion(seed, 2000, offset=0.0), motion(seed + 1, 2000, offset=0.0)
    u, v = commanded(compensator, y), commanded(compensator, z)
    assert_allclose(commanded(compensator, y + shift), u + shift, atol=1e-8)
    assert_allclose(commanded(compensator, y + factor * z), u + factor * v, atol=1e-8)


@pytest.mark.parametrize("method", ["lpfbs", "contour"])
def test_memory_of_an_endless_stretch_is_bounded(method):
    compensator = design(method, *described("35 Hz", "28 Hz"))
    stream = compensator.start(np.zeros(2))
    sent = got = 0
    for seed in range(30):
        y = motion(seed, 1000, offset=0.0)
        got += len(stream.push(y - y[0], np.ones(1000), False))
        sent += 1000
        assert sent - got <= compensator.preview + compensator.n_up * compensator.basis.L


@pytest.mark.parametrize("method", ["lpfbs", "robust_fbf", "contour"])
def test_a_stiffer_command_bends_less_four_times(method):
    y = motion(9, 1500)
    compensator = design(method, *described("taz6", "35 Hz"))
    bends = []
    while compensator is not None:
        bends.append(np.sqrt(np.mean(np.diff(commanded(compensator, y), 2, axis=0) ** 2)))
        compensator = compensator.stiffer()
    assert len(bends) == 5 and bends == sorted(bends, reverse=True)
