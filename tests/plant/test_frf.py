"""Responses measured from noise and sweeps: they agree with the truth, and know how far they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import FS, ONE, TWO, swept

from fbfcli.plant.frf import ESTIMATORS, combined, frf, from_table, shift_between, shifted, shifts, trusted
from fbfcli.plant.rational import response
from fbfcli.plant.spectra import short_time, welch

BAND = (5.0, 100.0)


@pytest.fixture(scope="module")
def pair():
    return swept(TWO, 0.05, np.random.default_rng(1))


def test_a_sweep_gives_the_complex_response(pair):
    found = trusted(frf(short_time(*pair, FS, BAND)))
    ratio = found.H / response(TWO, found.frequency)
    sure = found.coherence > 0.9
    assert sure.mean() > 0.9
    assert np.abs(np.abs(ratio[sure]) - 1).max() < 0.05
    assert np.abs(np.degrees(np.angle(ratio[sure]))).max() < 5


def test_random_errors_are_as_large_as_they_say(pair):
    found = trusted(frf(short_time(*pair, FS, BAND)))
    z = (found.H / response(TWO, found.frequency) - 1).real * np.abs(found.H) / found.sd
    assert 0.3 < np.sqrt(np.mean(z**2)) < 1.3


def test_coherence_of_a_sweep_is_that_of_the_seconds_in_which_it_was_there(pair):
    """A loud harmonic elsewhere in the record does not matter to the short-time average, and does to Welch's."""
    x, y = pair
    t = np.arange(len(x)) / FS
    quiet = t > 70.0  # the sweep has left 20 Hz long ago
    loud = y + np.where(quiet, 2000.0 * np.sin(2 * np.pi * 20.0 * t), 0.0)
    for averaged, low, high in ((short_time, 0.9, 1.0), (welch, 0.0, 0.8)):
        found = frf(averaged(x, loud, FS, BAND))
        at = np.argmin(np.abs(found.frequency - 20.0))
        assert low <= found.coherence[at] <= high


def test_h1_h2_and_hv_see_the_noise_where_they_say():
    rng = np.random.default_rng(2)
    x = rng.standard_normal(100_000)
    clean = 1.5 * x
    noise = 0.5 * rng.standard_normal((2, len(x)))
    for name, command, answer in (
        ("h1", x, clean + noise[0]),
        ("h2", x + noise[0] / 1.5, clean),
        ("hv", x + noise[0], clean + noise[1]),
    ):
        H = ESTIMATORS[name](welch(command, answer, FS, BAND))
        assert np.abs(np.mean(H)) == pytest.approx(1.5, rel=0.02)
    noisy = welch(x + noise[0], clean + noise[1], FS, BAND)
    assert np.mean(np.abs(ESTIMATORS["h1"](noisy))) < 1.5 < np.mean(np.abs(ESTIMATORS["h2"](noisy)))


def test_recordings_aligned_one_by_one_are_combined_without_wearing_away():
    rng = np.random.default_rng(3)
    one, other = (short_time(*swept(ONE, 0.05, rng, f1=60.0), FS, (5.0, 60.0)) for _ in range(2))
    late = shifted(other, -0.004)
    assert shift_between(one, late) == pytest.approx(0.004, abs=2e-5)
    found = frf(combined([one, late], shifts([one, late])))
    alone = frf(one)
    assert np.allclose(np.abs(found.H), np.abs(alone.H), rtol=0.1)
    assert found.count.mean() == pytest.approx(2 * alone.count.mean(), rel=0.05)


def test_lines_do_not_depend_on_the_rate(pair):
    x, y = pair
    slow = short_time(x[::2], y[::2], FS / 2, BAND, seconds=4.0)
    fast = short_time(x, y, FS, BAND, seconds=4.0)
    assert len(slow.frequency) == len(fast.frequency)
    assert np.abs(slow.frequency - fast.frequency).max() < 0.3


def test_a_stop_in_mid_motion_does_not_leak():
    x, y = swept(TWO, 0.0, np.random.default_rng(4), f1=130.0)
    cut = int(110 * FS)
    found = frf(short_time(x[:cut], y[:cut], FS, (5.0, 100.0)))
    assert np.abs(np.abs(found.H / response(TWO, found.frequency)) - 1)[found.frequency < 20].max() < 0.03


def test_trusted_leaves_lines_out_that_nothing_around_agrees_with(pair):
    found = frf(short_time(*pair, FS, BAND))
    lost = replace(found, coherence=np.where(found.frequency > 60, 0.1, found.coherence))
    assert trusted(lost).frequency.max() < 65


def test_a_table_without_coherence_has_errors_all_the_same():
    f = np.linspace(5, 60, 30)
    assert (from_table(f, response(ONE, f), None).sd > 0).all()
