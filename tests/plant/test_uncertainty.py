"""Laws of the family of plants that an axis may be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import freqz

from fbfcli.errors import ModelError
from fbfcli.plant.model import Plant, impulse_response, modes, plant_of
from fbfcli.plant.uncertainty import ASSUMED, Members, changed, members, tuned
from fbfcli.printer import Family, FrequencyResponse, ImpulseResponse, ModalModel, Mode, Spread, TransferFunction
from tests.control.control_cases import MODELS

DT = 1e-3
ONE = ModalModel((Mode(35.0, 0.05),))
TWO = ModalModel((Mode(45.0, 0.05, 0.8), Mode(85.0, 0.05, 0.2)))
each_model = pytest.mark.parametrize("name", MODELS)
factors = st.floats(0.7, 1.4)


def response(plant, f: np.ndarray) -> np.ndarray:
    """G at f [Hz], shape (n,)."""
    return freqz(plant.b, plant.a, 2 * np.pi * f * plant.dt)[1]


@given(factors, st.floats(0.5, 2.0), st.floats(20, 90), st.floats(0.02, 0.2))
def test_a_mode_moves_by_its_factors(q, d, f, zeta):
    mode = modes(changed(ModalModel((Mode(f, zeta),)), q, d, DT, "x"))[0]
    assert (mode.frequency, mode.damping) == pytest.approx((q * f, d * zeta), rel=1e-6)


@given(q=factors)
def test_modes_are_the_same_response_along_a_longer_axis(q):
    f = np.linspace(2.0, 60.0, 30)
    G, G_q = plant_of(TWO, DT, "x"), changed(TWO, q, 1.0, DT, "x")
    # a discrete plant's samples and holds stay at dt: what they add to the lag grows with frequency and step
    assert np.abs(np.abs(response(G_q, q * f) / response(G, f)) - 1).max() < 0.04
    assert G_q.b.sum() / G_q.a.sum() == pytest.approx(1.0, abs=1e-9)


@each_model
@given(q=factors, d=st.floats(0.5, 2.0))
def test_resonances_move_and_what_does_not_oscillate_stays(name, q, d):
    plant = plant_of(MODELS[name], DT, "x")
    moved = tuned(plant, q, d)
    for of in ("a", "b"):
        before, after = (np.roots(getattr(each, of)) for each in (plant, moved))
        real = [np.sort(roots[np.abs(roots.imag) < 1e-9].real) for roots in (before, after)]
        np.testing.assert_allclose(*real, rtol=1e-6)
        swinging = [np.sort(np.abs(np.log(roots[roots.imag > 1e-9]))) for roots in (before, after)]
        np.testing.assert_allclose(swinging[1], q * swinging[0], rtol=1e-6)
    assert (np.flatnonzero(moved.b)[0], len(moved.b)) == (np.flatnonzero(plant.b)[0], len(plant.b))
    assert moved.b.sum() / moved.a.sum() == pytest.approx(1.0)


def test_moving_to_and_fro_changes_nothing():
    plant = plant_of(MODELS["taz6"], DT, "x")
    back = tuned(tuned(plant, 0.8, 1.5), 1 / 0.8, 1 / 1.5)
    np.testing.assert_allclose(back.a, plant.a, rtol=1e-8)
    np.testing.assert_allclose(back.b, plant.b, rtol=1e-7)


def test_an_antiresonance_goes_with_its_resonance():
    """Base-excited, (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2) has no lag at rest, at whatever frequency."""
    hictop = MODELS["hictop"]
    lags = [float(np.arange(len(h)) @ h)
            for h in (impulse_response(changed(hictop, q, 1.0, DT, "x")) for q in (0.85, 1.0, 1.15))]  # fmt: skip
    assert np.abs(lags).max() < 0.05  # samples; with the poles alone 0.3


def test_a_root_that_would_pass_half_the_sampling_rate_stays():
    p = 0.5 * np.exp(1j * np.pi * np.array([0.9, -0.9]))  # 450 Hz
    a = np.real(np.poly(p))
    plant = Plant(np.array([a.sum()]), a, DT)
    np.testing.assert_allclose(tuned(plant, 1.2, 1.0).a, a)


@given(q=factors)
def test_a_response_is_resampled(q):
    model = ImpulseResponse(tuple(impulse_response(plant_of(ONE, DT, "x")).tolist()), DT)
    h, h_q = (impulse_response(plant) for plant in (plant_of(model, DT, "x"), changed(model, q, 1.0, DT, "x")))
    t = np.arange(len(h_q)) * q
    step = np.interp(t, np.arange(len(h)), np.cumsum(h), right=1.0)
    assert np.abs(np.cumsum(h_q) - step).max() < 2e-3


def test_a_frequency_response_is_moved_too():
    f = np.arange(0.5, 400.0, 0.5)
    G = 35.0**2 / (35.0**2 - f**2 + 2j * 0.1 * 35.0 * f)
    model = FrequencyResponse(tuple(f), tuple(np.abs(G)), tuple(np.angle(G)))
    peak = modes(changed(model, 1.2, 1.0, DT, "x"))[0]
    assert (peak.frequency, peak.damping) == pytest.approx((42.0, 0.1), rel=0.03)


@each_model
@given(d=st.floats(0.4, 2.0))
def test_damping_moves_alone(name, d):
    plant = plant_of(MODELS[name], DT, "x")
    before, after = (sorted(modes(p)) for p in (plant, tuned(plant, 1.0, d)))
    assert [m.frequency for m in after] == pytest.approx([m.frequency for m in before], rel=1e-6)
    assert [m.damping for m in after] == pytest.approx([d * m.damping for m in before], rel=1e-5)
    assert impulse_response(tuned(plant, 1.0, d)).sum() == pytest.approx(1.0)


@each_model
def test_a_family_surrounds_its_model(name):
    family = members(MODELS[name], ASSUMED, DT, "x")
    middle = len(family.plants) // 2
    assert len(family.plants) == 7
    assert family.weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(family.plants[middle].a, plant_of(MODELS[name], DT, "x").a)
    first, last = (max(m.frequency for m in modes(family.plants[i])) for i in (0, -1))
    assert last / first == pytest.approx(1.15 / 0.85, rel=1e-6)
    assert family.mean().sum() == pytest.approx(1.0)


def test_a_narrow_family_is_smaller_and_an_exact_one_is_one():
    assert len(members(ONE, Spread((0.9, 1.1)), DT, "x").plants) == 5
    assert len(members(ONE, Spread((0.85, 1.15), (0.5, 2.0)), DT, "x").plants) == 7 * 3
    assert len(members(ONE, Spread(), DT, "x").plants) == 1


@given(half=st.floats(0.05, 0.3))
def test_any_frequency_of_the_range_is_as_likely_as_any_other(half):
    family = members(ONE, Spread((1.0 - half, 1.0 + half)), DT, "x")
    f = np.array([modes(plant)[0].frequency for plant in family.plants]) / modes(plant_of(ONE, DT, "x"))[0].frequency
    assert family.weights @ f == pytest.approx(1.0, abs=1e-6)
    assert family.weights @ (f - 1.0) ** 2 == pytest.approx(half**2 / 3, rel=2.1 / (len(f) - 1) ** 2)  # trapezoids


def test_named_models_keep_their_probabilities():
    family = members(ONE, Family((ONE, ModalModel((Mode(50.0, 0.1),))), (0.25, 0.75)), DT, "x")
    np.testing.assert_allclose(family.weights, [0.25, 0.75])
    assert modes(family.plants[1])[0].frequency == pytest.approx(50.0)
    mean = 0.25 * impulse_response(family.plants[0])[:100] + 0.75 * impulse_response(family.plants[1])[:100]
    np.testing.assert_allclose(family.mean()[:100], mean)


def test_a_member_that_is_no_plant_is_refused_by_the_name_of_its_axis():
    with pytest.raises(ModelError, match="axis y"):
        members(ONE, Family((TransferFunction((1.0,), (1.0, -1.1), DT),), (1.0,)), DT, "y")


def test_the_mean_of_one_is_itself():
    plant = plant_of(ONE, DT, "x")
    np.testing.assert_array_equal(Members((plant,), np.ones(1)).mean(), impulse_response(plant))
