"""Robust FBF: the paper's filter in the basis and the expected least squares say the same where theory says so."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from control_cases import DT, commanded, described, family, motion
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.signal import lfilter

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.basis import uniform_basis
from fbfcli.control.design import design
from fbfcli.control.robust import robust_filter
from fbfcli.control.robust_basis import robust_response
from fbfcli.errors import ModelError


@cache
def axis() -> AxisModel:
    return family(40.0, 0.08, 0.15, 5)


def test_the_response_is_that_of_the_robust_filter():
    h, before = robust_response(axis())
    assert before > 100  # it begins well before the impulse
    n = 1 << 14
    G = np.array([np.fft.rfft(h_j, n) for h_j in axis().family])
    delayed = np.fft.rfft(h, n) * np.exp(2j * np.pi * np.fft.rfftfreq(n) * before)
    assert_allclose(delayed, robust_filter(G, axis().weights), atol=2e-3 * np.abs(G).max())


def test_one_plant_is_its_own_robust_filter():
    alone = family(40.0, 0.08, 0.0, 1)
    assert_array_equal(robust_response(alone)[0], alone.h / alone.h.sum())
    y = motion(0, 1500)[:, :1]
    for robust, plain in (("robust", "lpfbs"), ("robust_fbf", "fbf")):
        assert_allclose(commanded(design(robust, [alone], DT), y), commanded(design(plain, [alone], DT), y), atol=1e-9)


def test_the_command_is_the_optimal_controllers():
    """A slow sine, long enough: u = y E[G*] / E[G G*] at its frequency, by both, within 1 %."""
    for f in (10.0, 40.0):
        k = np.arange(6000)
        fade = np.clip(np.minimum(k, 5999 - k) / 1000, 0, 1)
        y = (fade**2 * (3 - 2 * fade) * np.sin(2 * np.pi * f * k * DT))[:, None]
        y[:60] = y[-60:] = 0.0
        wave = np.exp(-2j * np.pi * f * k * DT)
        G = np.array([wave[: len(h)] @ h for h in axis().family])
        wanted = (axis().weights @ G.conj()) / (axis().weights @ np.abs(G) ** 2)
        middle = slice(2000, 4000)
        for name in ("robust", "robust_fbf"):
            u = commanded(design(name, [axis()], DT, {"L": 2, "mu": 1e-6}), y)
            got = (u[middle, 0] @ wave[middle]) / (y[middle, 0] @ wave[middle])
            assert abs(got - wanted) < 0.01 * abs(wanted), (name, f)


def test_they_agree_as_knots_come_closer():
    """Both are y E[G*] / E[G G*] where the splines can do all; they differ in how they weigh what these cannot do."""
    y = motion(2, 1800, 1, hold=60)

    def command(name: str, L: int) -> np.ndarray:
        whole = {} if name == "robust_fbf" else {"preview": 2000}
        return commanded(design(name, [axis()], DT, {"L": L, "mu": 0.0, **whole}), y)

    coarse, fine = (np.sqrt(np.mean((command("robust", L) - command("robust_fbf", L)) ** 2)) for L in (24, 6))
    from_nominal = np.sqrt(np.mean((command("robust", 6) - command("lpfbs", 6)) ** 2))
    assert fine < 0.9 * coarse and fine < 0.04 * from_nominal, (coarse, fine, from_nominal)


@pytest.mark.parametrize("mu", [0.0, 5.0])
def test_expected_least_squares_agree_with_a_dense_solve(mu):
    L, m = 6, 5
    y = motion(4, 260, 1)
    basis = uniform_basis(m, L)
    n, end = basis.free(len(y)), y[-1, 0] - y[0, 0]
    filtered = [np.convolve(h, basis.beta) for h in axis().family]
    S = max(-(-len(f) // L) for f in filtered)
    columns, rows = n + S, (n + 2 * S) * L

    def lifted(one):
        matrix = np.zeros((rows + columns * L, columns))
        for i in range(columns):
            matrix[i * L : i * L + len(one), i] = one
        return matrix[:rows]

    Phi = [np.sqrt(weight) * lifted(f) for f, weight in zip(filtered, axis().weights, strict=True)]
    target = [np.sqrt(weight) * np.append(y[:, 0] - y[0, 0], np.full(rows - len(y), end)) for weight in axis().weights]
    bent = np.sqrt(mu) * lifted(np.convolve(basis.beta, [1.0, -2.0, 1.0]))[: (n + m + 1) * L + 2]
    A, t = np.vstack((*Phi, bent)), np.concatenate((*target, np.zeros(len(bent))))
    scale = np.linalg.norm(A[:, :n], axis=0)
    t = t - A[:, n:] @ np.full(S, end)
    reach = (rows // L - S) * L  # where all responses are whole
    keep = np.concatenate([np.arange(len(Phi) * rows).reshape(-1, rows)[:, :reach].ravel(),
                           len(Phi) * rows + np.arange(len(bent))])  # fmt: skip
    gamma = np.linalg.lstsq(A[keep][:, :n] / scale, t[keep], rcond=None)[0] / scale
    u = y[0, 0] + lifted(basis.beta)[: len(y)] @ np.append(gamma, np.full(S, end))
    assert_allclose(commanded(design("robust_fbf", [axis()], DT, {"L": L, "mu": mu}), y)[:, 0], u, atol=1e-8)


@given(
    seed=st.integers(0, 10**6),
    samples=st.integers(1, 4000),
    pieces=st.lists(st.integers(1, 1500), min_size=1, max_size=5),
    name=st.sampled_from(["robust", "robust_fbf"]),
)
@settings(max_examples=15, deadline=None)
def test_pieces_of_any_size_give_the_same(seed, samples, pieces, name):
    compensator = robust(name)
    y = motion(seed, samples, 1)
    whole = commanded(compensator, y)
    assert_allclose(commanded(compensator, y, pieces), whole, atol=1e-9)
    assert_array_equal(whole[[0, -1]], y[[0, -1]])


@cache
def robust(name: str):
    return design(name, [axis()], DT)


@pytest.mark.parametrize("name", ["robust", "robust_fbf"])
def test_the_expected_error_is_less_than_the_nominal_models(name):
    y = motion(5, 3000, 1, hold=60)
    plain = design("lpfbs", [axis()], DT)

    def expected(compensator) -> float:
        u = commanded(compensator, y)[:, 0] - y[0, 0]
        return float(np.mean([np.mean((np.convolve(u, h)[: len(u)] + y[0, 0] - y[:, 0]) ** 2) for h in axis().family]))

    assert expected(robust(name)) < 0.85 * expected(plain)


def test_limited_preview_is_within_half_a_micrometre_of_full_preview():
    y = motion(6, 3500, 1)
    windows, one = (design("robust", [axis()], DT, {"L": 8, **preview}) for preview in ({}, {"preview": 2000}))
    assert windows.n_c * 8 < len(y) < one.n_c * 8
    assert_allclose(commanded(windows, y), commanded(one, y), atol=5e-4)


def test_a_family_whose_members_cancel_is_refused():
    model = described("35 Hz")[0][0]
    opposed = AxisModel(model.b, model.a, model.h, model.modes,
                        (np.array([0.75, 0.25]), np.array([0.25, 0.75])), np.array([0.5, 0.5]))  # fmt: skip
    with pytest.raises(ModelError, match="cancel"):
        robust_response(opposed)


def test_a_line_at_constant_speed_is_led_by_the_mean_delay():
    y = np.interp(np.arange(6000), [0, 200, 5800, 6000], [0, 0, 280, 280])[:, None]
    u = commanded(robust("robust"), y)
    mean = np.mean([lfilter(h, 1.0, u[:4000, 0]) for h in axis().family], axis=0)
    assert np.abs(mean[2500:3500] - y[2500:3500, 0]).max() < 1e-3
