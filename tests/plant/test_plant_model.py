"""Plants are stable, of unit DC gain, and say what the profile's model says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.signal import freqz, lfilter, lsim

from fbfcli.errors import ModelError
from fbfcli.plant.model import impulse_response, modes, plant_of
from fbfcli.printer import FrequencyResponse, ImpulseResponse, ModalModel, Mode, TransferFunction

DT = 1e-3
TAZ6 = TransferFunction(
    (0, 0.0874002643, -0.3414755673, 0.5118203207, -0.3480853557, 0.0906300805),
    (1, -4.5399420515, 8.2830579485, -7.5829420515, 3.4790579485, -0.6389420515), DT)  # fmt: skip
HICTOP = TransferFunction(
    (0, 0.0260166669, -0.0479750004, -0.0029833334, 0.0480250004, -0.0229833335),
    (1, -4.79178, 9.27422, -9.05978, 4.46622, -0.88878), DT)  # fmt: skip
TWO_MODES = ModalModel((Mode(45, 0.05, 0.8), Mode(85, 0.05, 0.2)))


@pytest.mark.parametrize(("model", "frequencies", "length"), [(TAZ6, (24.8, 33.4), 465), (HICTOP, (40.8, 27.1), 1070)])
def test_published_models_are_stable_with_unit_gain_and_their_modes(model, frequencies, length):
    plant = plant_of(model, DT, "x")
    assert np.abs(np.roots(plant.a)).max() < 1
    assert plant.b.sum() / plant.a.sum() == pytest.approx(1, abs=1e-12)
    assert [round(mode.frequency, 1) for mode in modes(plant)] == list(frequencies)
    assert length <= len(impulse_response(plant)) <= 1.02 * length


def test_zeros_of_the_published_models():
    assert_allclose(sorted(np.roots(TAZ6.b[1:]), key=abs)[-1].real, 0.9924, atol=1e-4)
    assert np.abs(np.roots(HICTOP.b[1:]) + 1).min() < 1e-3


@given(st.floats(15, 120), st.floats(0.01, 0.3), st.floats(15, 120), st.floats(0.01, 0.3), st.floats(0.2, 0.8))
@settings(max_examples=50, deadline=None)
def test_modes_of_a_modal_plant_are_its_modes(f_1, zeta_1, f_2, zeta_2, gain):
    if abs(f_1 - f_2) < 3:
        f_2 = f_1 + 10
    plant = plant_of(ModalModel((Mode(f_1, zeta_1, gain), Mode(f_2, zeta_2, 1 - gain))), DT, "x")
    found = sorted((mode.frequency, mode.damping) for mode in modes(plant))
    assert_allclose(found, sorted([(f_1, zeta_1), (f_2, zeta_2)]), rtol=1e-4)


def test_modal_plant_is_exact_for_a_piecewise_linear_command():
    w, zeta = 2 * np.pi * 35, 0.05
    t = np.arange(300) * DT
    u = np.cumsum(np.random.default_rng(0).standard_normal(300))
    u -= u[0]
    plant = plant_of(ModalModel((Mode(35, zeta),)), DT, "x")
    _, exact, _ = lsim(([w**2], [1, 2 * zeta * w, w**2]), u, t, interp=True)
    assert_allclose(lfilter(plant.b, plant.a, u), exact, atol=1e-9)


@pytest.mark.parametrize("model", [TAZ6, HICTOP, TWO_MODES])
def test_impulse_response_sums_to_one_and_has_died_out(model):
    h = impulse_response(plant_of(model, DT, "x"))
    assert h.sum() == pytest.approx(1, abs=1e-12)
    assert np.abs(h[-30:]).max() < 5e-5 * np.abs(h).max()


@pytest.mark.parametrize("model", [TAZ6, HICTOP])
@pytest.mark.parametrize("ratio", [2, 4])
def test_resampled_transfer_function_keeps_its_step_response(model, ratio):
    coarse, fine = plant_of(model, DT, "x"), plant_of(model, DT / ratio, "x")
    step = lfilter(fine.b, fine.a, np.ones(400 * ratio))[::ratio]
    assert_allclose(step, lfilter(coarse.b, coarse.a, np.ones(400)), atol=1e-6)


@pytest.mark.parametrize("model", [TAZ6, HICTOP, TWO_MODES])
def test_finite_response_has_the_modes_of_what_it_samples(model):
    plant = plant_of(model, DT, "x")
    h = impulse_response(plant)
    same = plant_of(ImpulseResponse(tuple(h), DT), DT, "x")
    assert_allclose(np.array(modes(same))[:2, :2], np.array(modes(plant))[:2, :2], rtol=1e-4)
    assert_allclose(impulse_response(same), h, atol=1e-15)


def test_finite_response_is_resampled_with_its_gain_and_delay():
    h = impulse_response(plant_of(TWO_MODES, DT, "x"))
    half = impulse_response(plant_of(ImpulseResponse(tuple(h), DT), DT / 2, "x"))
    assert half.sum() == pytest.approx(1, abs=1e-12)
    assert np.arange(len(half)) @ half * DT / 2 == pytest.approx(np.arange(len(h)) @ h * DT, abs=DT)


@pytest.mark.parametrize("model", [TAZ6, HICTOP, TWO_MODES])
def test_frequency_response_becomes_a_causal_response_that_gives_it_back(model):
    plant = plant_of(model, DT, "x")
    f = np.arange(2, 200, 0.5)
    _, H = freqz(plant.b, plant.a, f, fs=1 / DT)
    measured = FrequencyResponse(tuple(f), tuple(np.abs(H)), tuple(np.angle(H)))
    _, again = freqz(impulse_response(plant_of(measured, DT, "x")), 1, f, fs=1 / DT)
    assert np.abs(again - H)[f < 100].max() < 0.05 * np.abs(H).max()


def test_dc_gain_within_two_percent_is_normalised():
    plant = plant_of(TransferFunction((0, 0.505), (1, -0.5), DT), DT, "x")
    assert plant.b.sum() / plant.a.sum() == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (TransferFunction((0, 0.1), (1, -1.2), DT), "unstable.*1.2"),
        (TransferFunction((0, 0.1), (1, -1.0), DT), "undamped"),
        (TransferFunction((0, 0.1), (1, -0.5), DT), "gain at 0 Hz is 0.2"),
        (TransferFunction((0, np.nan), (1, -0.5), DT), "finite"),
        (TransferFunction((0, 1e-4), (1, -0.9999), DT), "20000"),
        (TransferFunction((0, 1.5), (1, 0.5), 2 * DT), "cannot be brought to 0.001 s"),
        (ImpulseResponse((0.5, 0.2), DT), "gain at 0 Hz is 0.7"),
        (ImpulseResponse(tuple(np.full(30_000, 1 / 30_000)), DT), "20000"),
        (FrequencyResponse(tuple(range(1, 20)), (1.0,) * 19, ()), "no phase"),
        (FrequencyResponse(tuple(range(1, 20)), (1.0,) * 19, (0.0,) * 19), "no phase"),
        (FrequencyResponse(tuple(range(1, 20)), (1000.0,) * 19, (0.1,) * 19), "1 Hz is 1e\\+03"),
    ],
)
def test_what_is_no_plant_is_refused_with_its_value(model, words):
    with pytest.raises(ModelError, match=words) as refused:
        plant_of(model, DT, "x")
    assert "axis x" in str(refused.value) and "\n" not in str(refused.value)


def test_a_mode_of_no_gain_changes_no_response():
    one = plant_of(ModalModel((Mode(40.0, 0.05),)), 1e-3, "x")
    more = plant_of(ModalModel((Mode(40.0, 0.05), Mode(70.0, 0.1, 0.0))), 1e-3, "x")
    h, g = impulse_response(one), impulse_response(more)
    n = min(len(h), len(g))
    np.testing.assert_allclose(h[:n], g[:n], atol=5e-6)  # each is cut at 1e-5 of its own envelope
