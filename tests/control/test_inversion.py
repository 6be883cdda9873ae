"""Inverse methods: their metrics to rounding, where they apply, and what they make of a plant."""

from __future__ import annotations

import numpy as np
import pytest
from control_cases import PLANTS
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.control.factored_plant import MAX_ZEROS, cancellable, factored
from fbfcli.control.inversion import (
    extended_zpetc,
    npz_ignore,
    stable_inversion,
    truncated_series,
    zmetc,
    zpetc,
)
from fbfcli.control.two_sided import TwoSided
from fbfcli.errors import ModelError

M, POLE = 1000, 0.5
NONE_CANCELLED = 2.0
OMEGA = np.linspace(0, np.pi, 101)
METHODS = (npz_ignore, zpetc, zmetc, extended_zpetc, truncated_series, stable_inversion)

outside = st.one_of(st.floats(1.02, 5), st.floats(-5, -1.02))
inside = st.one_of(st.floats(0.02, 0.98), st.floats(-0.98, -0.02))


def plant(a):
    return factored([1, -a], [1, -POLE], NONE_CANCELLED)


def response(b, a, omega=OMEGA):
    z = np.exp(-1j * omega)
    return np.polyval(b[::-1], z) / np.polyval(a[::-1], z)


@given(outside | inside)
def test_zpetc_has_the_metric_of_eq_2_28(a):
    expected = np.sqrt(6 - 2 / (M + 1)) * abs(a) / (1 - a) ** 2
    assert zpetc(plant(a)).L.error().frobenius(M + 1) == pytest.approx(expected, rel=1e-9)


@given(outside | inside, st.integers(1, 12))
def test_a_truncated_series_has_the_metric_of_eq_2_29(a, terms):
    expected = np.sqrt(1 - terms / (M + 1)) * min(abs(a), 1 / abs(a)) ** terms
    found = truncated_series(plant(a), terms).L.error().frobenius(M + 1)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-13)


@given(outside | inside)
def test_what_each_method_leaves(a):
    """No phase, no magnitude error, unit gain at rest, nothing at all."""
    G = plant(a)
    assert np.abs(zpetc(G).L.response(OMEGA).imag).max() < 1e-9 * (1 + a**2) / (1 - a) ** 2
    assert np.abs(np.abs(zmetc(G).L.response(OMEGA)) - 1).max() < 1e-9
    assert npz_ignore(G).L.c.sum() == pytest.approx(1, abs=1e-9)
    assert np.abs(stable_inversion(G).L.error().c).sum() < 1e-9


@given(st.floats(-5, -1.001) | st.floats(6, 20), st.integers(0, 8))
def test_extended_zpetc_gets_better_with_every_term(a, terms):
    few, more = (extended_zpetc(plant(a), n).L.error().frobenius(M + 1) for n in (terms, terms + 1))
    assert more < few * (1 + 1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("a", [1.0, -1.0])
def test_zeros_on_the_unit_circle(method, a):
    """NPZ-ignore and (extended) ZPETC need only B_u(1); the others divide by B_u everywhere."""
    if a == -1 and method in (npz_ignore, zpetc, extended_zpetc):
        assert method(plant(a)).L.c.sum() == pytest.approx(1)
    else:
        with pytest.raises(ModelError, match="does not apply"):
            method(plant(a))


@pytest.mark.parametrize(("a", "converges"), [(0.17, True), (0.18, False), (2, False), (5.82, False), (5.84, True)])
def test_the_series_of_extended_zpetc_converges_where_its_error_is_under_one(a, converges):
    """4 a <= (1 - a)^2, that is up to 3 - sqrt(8) and from 3 + sqrt(8) on."""
    if converges:
        assert np.isfinite(extended_zpetc(plant(a)).L.c).all()
    else:
        with pytest.raises(ModelError, match="converge"):
            extended_zpetc(plant(a))


@pytest.mark.parametrize("name", list(PLANTS))
@pytest.mark.parametrize("method", METHODS)
def test_the_controller_behind_the_plant_is_the_overall_dynamics(name, method):
    G = PLANTS[name]
    try:
        made = method(factored(G.b, G.a))
    except ModelError:
        assert (name, method) in {("hictop", m) for m in (zmetc, truncated_series, stable_inversion)} | {
            ("taz6", extended_zpetc)}  # fmt: skip
        return
    through, expected = made.C.response(OMEGA) * response(G.b, G.a), made.L.response(OMEGA)
    assert np.abs(through - expected).max() < 1e-7 * np.abs(expected).max()


def test_zeros_are_sorted_by_their_damping():
    z = np.array([0.5, -0.26, 0.9773 * np.exp(0.182j), 0.9999 * np.exp(1j), 0.999, 1.0, -1.0, 1.04j, -3.7])
    assert cancellable(z).tolist() == [True, True, True, False, False, False, False, False, False]
    assert not cancellable(z, NONE_CANCELLED).any()


def test_factors_make_up_the_plant():
    for G in PLANTS.values():
        parts = factored(G.b, G.a)
        product = np.concatenate((np.zeros(parts.d), np.convolve(parts.B_s, parts.B_u)))
        np.testing.assert_allclose(product, np.trim_zeros(G.b, "b"), atol=1e-9 * np.abs(G.b).max())
        assert not cancellable(parts.zeros_u).any()


def test_an_impulse_response_has_no_zeros_to_invert():
    with pytest.raises(ModelError, match="modes or a transfer function"):
        factored(np.hanning(MAX_ZEROS + 10), [1.0])


def test_more_preview_inverts_better():
    G = PLANTS["taz6"]
    errors = [stable_inversion(factored(G.b, G.a), n).L.error().frobenius(M) for n in (20, 80, 320)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


@given(st.lists(st.floats(-2, 2), min_size=1, max_size=8), st.integers(-5, 5), st.integers(0, 2**32 - 1))
def test_a_two_sided_filter_is_its_toeplitz_matrix(c, ahead, seed):
    n = 30
    T = np.zeros((n, n))
    for j, value in enumerate(c):
        T += value * np.eye(n, k=ahead - j)
    filter_ = TwoSided(np.array(c), ahead)
    x = np.random.default_rng(seed).standard_normal((n, 2))
    np.testing.assert_allclose(filter_.filtered(x), T @ x, atol=1e-12)
    assert filter_.frobenius(n) == pytest.approx(np.linalg.norm(T) / np.sqrt(n), abs=1e-12)
    np.testing.assert_allclose(filter_.error().filtered(x), x - T @ x, atol=1e-12)
