"""What windows do to a response is taken out; what the model does not explain stays."""

from __future__ import annotations

import numpy as np
import pytest
from response_cases import frf_of

from fbfcli.plant.alignment import Pair
from fbfcli.plant.excitation import acceleration
from fbfcli.plant.fit import candidates, refitted
from fbfcli.plant.frf import frf, trusted
from fbfcli.plant.klipper_test import klipper_test
from fbfcli.plant.rational import Rational, Resonance, response
from fbfcli.plant.rehearsal import left_over, steadied, without_windows
from fbfcli.plant.shape import Shape, vector_of
from fbfcli.plant.spectra import short_time

FS, BAND = 400.0, (5.0, 60.0)
TRUTH = Rational((Resonance(21.0, 0.03, 0.7), Resonance(37.0, 0.02, 0.3)))
PASSES = 3  # rehearsals
NOISE = 0.02  # of the response's rms


@pytest.fixture(scope="module")
def pair():
    """A sweep of 4 Hz/s, in which a mode of 21 Hz has a quarter of a second, and 2 % of noise."""
    sweep = klipper_test(f1=60.0, hz_per_sec=4.0, sweeping_period=0.0)
    t = np.arange(int((sweep.duration + 3.0) * FS)) / FS - 1.0
    x = acceleration(sweep, t, 1 / FS)
    n = 4 * len(x)
    y = np.fft.irfft(np.fft.rfft(x, n) * response(TRUTH, np.fft.rfftfreq(n, 1 / FS)), n)[: len(x)]
    y += NOISE * y.std() * np.random.default_rng(0).standard_normal(len(y))
    return Pair(FS, x, y[:, None], ("x",), "x")


def passes(pair, count):
    """Responses as the windows show it and after each rehearsal, and the model after the last."""
    seen = frf(short_time(pair.command, pair.measured, FS, BAND))
    found = [trusted(seen)]
    best = candidates(found[0])[0]
    for _ in range(count):
        left = short_time(pair.command, left_over(pair, best), FS, BAND)
        found.append(trusted(without_windows(seen, left, best)))
        best = refitted(found[-1], best)
    return found, best


def worst_near_modes(found):
    H = response(TRUTH, found.frequency)
    return np.abs(found.H / H - 1)[np.abs(H) > 3.0].max()


def test_rehearsals_come_to_the_truth(pair):
    found, best = passes(pair, PASSES)
    assert worst_near_modes(found[0]) > 0.1
    assert worst_near_modes(found[-1]) < 0.01
    assert np.exp(best.theta[4]) == pytest.approx(0.03, rel=5e-3)
    assert not found[-1].width.any()


def test_the_truth_leaves_the_noise_over(pair):
    _, best = passes(pair, 0)
    true = best.__class__(Shape(2), vector_of(Shape(2), TRUTH, 1.0, 0.0), best.residual, best.derivatives, 0.0)
    assert left_over(pair, true).std() == pytest.approx(NOISE * pair.measured.std(), rel=0.03)


def test_a_shown_response_has_less_noise_where_only_noise_is_left():
    noisy = frf_of(TRUTH, 0.04, np.random.default_rng(1))
    model = candidates(noisy)[0]
    shown = steadied(noisy, model)
    errors = [np.abs(one.H / response(TRUTH, one.frequency) - 1) for one in (noisy, shown)]
    assert np.sqrt(np.mean(errors[1] ** 2)) < 0.5 * np.sqrt(np.mean(errors[0] ** 2))
    assert (shown.sd <= noisy.sd * 1.0001).all()


def test_what_a_model_does_not_explain_is_shown_as_measured():
    sure = frf_of(TRUTH, 0.01, np.random.default_rng(1))
    one = next(c for c in candidates(sure) if c.misfit > 0.1)
    np.testing.assert_array_equal(steadied(sure, one).H, sure.H)
