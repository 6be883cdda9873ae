"""Models fitted to responses: true ones are found, with intervals that hold the truth, and no pole is ever unstable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from response_cases import LAGGING, ONE, TWO, frf_of
from scipy.signal import freqz

from fbfcli.cli.lookup import bundled
from fbfcli.errors import ModelError
from fbfcli.plant.fit import averaged, candidates, prior
from fbfcli.plant.frf import Frf, at_lines
from fbfcli.plant.intervals import covariance, draws, mode_estimates, told_modes
from fbfcli.plant.model import modes, plant_of
from fbfcli.plant.rational import Rational, Resonance, discretised, profile_model, response, zeros
from fbfcli.plant.shape import Shape, delay_at_rest, measured_response, model_of, vector_of
from fbfcli.plant.vector_fitting import fit_poles, starting_poles
from fbfcli.printer import ModalModel, TransferFunction


@pytest.mark.parametrize("truth, shape", [(ONE, Shape(1)), (TWO, Shape(2)), (LAGGING, Shape(2, 1, True))])
def test_the_true_shape_is_chosen_and_its_modes_found(truth, shape):
    best = candidates(frf_of(truth, 0.01, np.random.default_rng(0), gain=1.04, delay=-0.003))[0]
    assert best.shape == shape
    assert np.exp(best.theta[0]) == pytest.approx(1.04, abs=0.02)
    found = sorted((r.frequency, r.damping) for r in model_of(best.shape, best.theta).resonances)
    true = sorted((r.frequency, r.damping) for r in truth.resonances)
    assert np.allclose([f for f, _ in found], [f for f, _ in true], rtol=0.005)
    assert np.allclose([z for _, z in found], [z for _, z in true], rtol=0.1)


def test_the_delay_of_clocks_stays_out_of_the_model():
    for delay in (-0.006, 0.004):
        best = candidates(frf_of(TWO, 0.01, np.random.default_rng(1), delay=delay))[0]
        assert best.theta[1] == pytest.approx(delay, abs=1e-4)
        f = np.linspace(5, 100, 50)
        assert np.abs(response(model_of(best.shape, best.theta), f) / response(TWO, f) - 1).max() < 0.05


def test_intervals_hold_the_truth_in_19_of_20_draws():
    held = []
    for seed in range(25):
        frf = frf_of(ONE, 0.02, np.random.default_rng(seed))
        best = candidates(frf)[0]
        mode = mode_estimates(best, covariance(frf, best))[0]
        held += [mode.frequency.low < 38.0 < mode.frequency.high, mode.damping.low < 0.05 < mode.damping.high]
    assert 0.88 <= np.mean(held) <= 1.0


@settings(max_examples=4)
def of_a_filter(noise: float, rng: np.random.Generator) -> tuple[Frf, list[tuple[float, float]]]:
    """A response of the TAZ 6, a filter at 1 kHz, and its modes: frequency, damping."""
    model = bundled()["taz6"].axes[0].model
    assert isinstance(model, TransferFunction)
    of = frf_of(ONE, noise, rng)
    H = freqz(model.b, model.a, of.frequency, fs=1 / model.dt)[1]
    error = noise * np.abs(H) * (rng.standard_normal(len(H)) + 1j * rng.standard_normal(len(H)))
    found = [(mode.frequency, mode.damping) for mode in modes(plant_of(model, model.dt, "X"))]
    return replace(of, H=H + error, sd=noise * np.abs(H)), sorted(found)


def test_what_a_filter_has_above_the_band_does_not_bend_its_modes():
    """Left out, that residual of 0.3 % puts the dampings of the TAZ 6 1.6 and 1.9 % off."""
    response_of_filter, truth = of_a_filter(2e-4, np.random.default_rng(3))
    found = told_modes(response_of_filter, candidates(response_of_filter))
    for (f, zeta), mode in zip(truth, sorted(found, key=lambda m: m.frequency.value), strict=True):
        assert mode.frequency.value == pytest.approx(f, rel=0.0005)
        assert mode.damping.value == pytest.approx(zeta, rel=0.005)


def test_intervals_hold_what_rival_shapes_say():
    measured = frf_of(LAGGING, 0.01, np.random.default_rng(4))
    chosen, *others = candidates(measured)
    rival = next(c for c in others if c.shape.pairs == chosen.shape.pairs)
    alone = told_modes(measured, [chosen, replace(rival, akaike=chosen.akaike + 11)])
    by_itself = mode_estimates(chosen, covariance(measured, chosen))
    assert [m.damping.high for m in alone] == pytest.approx([m.damping.high for m in by_itself])
    as_good = told_modes(measured, [chosen, replace(rival, akaike=chosen.akaike)])
    theirs = mode_estimates(rival, covariance(measured, rival))
    for mode, before in zip(as_good, alone, strict=True):
        assert mode.frequency.value == before.frequency.value
        other = min(theirs, key=lambda m: abs(np.log(m.frequency.value / mode.frequency.value)))
        apart = np.log(other.damping.value / mode.damping.value)
        half = [np.log(m.damping.high / m.damping.value) / 1.96 for m in (before, other)]
        expected = np.sqrt(0.5 * (half[0] ** 2 + half[1] ** 2 + apart**2))
        assert np.log(mode.damping.high / mode.damping.value) / 1.96 == pytest.approx(expected)


@given(st.lists(st.tuples(st.floats(12, 110), st.floats(0.02, 0.2)), min_size=1, max_size=2), st.integers(0, 99))
def test_every_candidate_is_stable_and_follows_its_command_at_rest(modes, seed):
    truth = Rational(tuple(Resonance(f, zeta, 1 / len(modes)) for f, zeta in modes))
    frf = frf_of(truth, 0.05, np.random.default_rng(seed))
    for candidate in candidates(at_lines(frf, np.arange(160) % 2 == 0)):
        model = model_of(candidate.shape, candidate.theta)
        assert all(r.damping > 0 for r in model.resonances) and all(lag.rate > 0 for lag in model.lags)
        b, a = discretised(model, 1e-3)
        assert np.abs(np.roots(a)).max() < 1
        assert b.sum() / a.sum() == pytest.approx(1.0, abs=1e-6)


def test_derivatives_are_those_of_the_model():
    shape = Shape(2, 1, True)
    theta = vector_of(shape, LAGGING, 1.1, 0.002, 1e-6)
    s = 2j * np.pi * np.linspace(5, 90, 20)
    _, J = measured_response(shape, theta, s)
    frf = frf_of(LAGGING, 0.01, np.random.default_rng(0))
    for i in range(shape.size):
        step = np.zeros(shape.size)
        step[i] = 1e-6 * max(1e-3, abs(theta[i]))
        ahead, behind = (measured_response(shape, theta + sign * step, s)[0] for sign in (1, -1))
        assert np.allclose((ahead - behind) / (2 * step[i]), J[:, i], rtol=1e-4, atol=1e-5 * np.abs(J[:, i]).max())
        slope = (prior(shape, theta + step, frf)[0] - prior(shape, theta - step, frf)[0]) / (2 * step[i])
        assert np.allclose(slope, prior(shape, theta, frf)[1][:, i], rtol=1e-4, atol=1e-6)


def test_delay_at_rest_is_the_phase_s_slope():
    theta = vector_of(Shape(2, 1, True), LAGGING, 1.0, 0.0)
    w = 2 * np.pi * 0.01
    slope = -np.angle(response(LAGGING, np.array([0.01])))[0] / w
    assert delay_at_rest(Shape(2, 1, True), theta)[0] == pytest.approx(slope, rel=1e-4)


def test_a_line_shows_the_mean_over_its_width():
    frf = replace(frf_of(ONE, 0.0, np.random.default_rng(0)), width=np.full(160, 0.5))
    theta = vector_of(Shape(1), ONE, 1.0, 0.0)
    f = frf.frequency[:, None] + frf.width[:, None] * np.linspace(-0.5, 0.5, 201)
    assert np.allclose(averaged(Shape(1), theta, frf)[0], response(ONE, f).mean(axis=1), rtol=2e-3)


def test_vector_fitting_finds_the_poles_of_a_rational_function():
    s = 2j * np.pi * np.linspace(5, 120, 200)
    poles = fit_poles(s, response(TWO, s.imag / (2 * np.pi)), np.ones(200), starting_poles(2, 0, (5.0, 120.0)))
    found = np.sort(np.abs(poles[poles.imag > 0])) / (2 * np.pi)
    assert np.allclose(found, [30.0, 55.0], rtol=1e-6)


def test_zeros_outside_the_stable_region_are_kept():
    model = Rational((Resonance(24.8, 0.16, 0.6, -0.4), Resonance(33.4, 0.14, 0.4, -0.3)))
    assert (zeros(model).real > 0).any()
    best = candidates(frf_of(model, 0.01, np.random.default_rng(5)))[0]
    assert (zeros(model_of(best.shape, best.theta)).real > 0).any()


def test_a_profile_s_model_is_the_fitted_one():
    for model, form in ((TWO, ModalModel), (LAGGING, TransferFunction)):
        written = profile_model(model, 1e-3)
        assert isinstance(written, form)
        plant = plant_of(written, 1e-3, "X")
        f = np.linspace(1, 90, 40)
        z = np.exp(-2j * np.pi * f * 1e-3)
        H = np.polyval(plant.b[::-1], z) / np.polyval(plant.a[::-1], z)
        hold = np.sinc(f * 1e-3) ** 2  # a command that is linear between samples
        assert np.abs(H / (hold * response(model, f)) - 1).max() < 0.02


def test_draws_spread_as_far_as_the_covariance_says():
    frf = frf_of(ONE, 0.02, np.random.default_rng(7))
    best = candidates(frf)[0]
    cov = covariance(frf, best)
    spread = np.std([np.log(r.resonances[0].frequency) for r in draws(best, cov, 300, np.random.default_rng(0))])
    assert spread == pytest.approx(np.sqrt(cov[3, 3]), rel=0.2)


def test_too_few_lines_and_noise_are_refused():
    frf = frf_of(ONE, 0.01, np.random.default_rng(0))
    with pytest.raises(ModelError, match="lines"):
        candidates(at_lines(frf, np.arange(160) < 8))
