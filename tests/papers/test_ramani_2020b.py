"""Ramani 2020b: robust FBF where its filter is unstable, where the plant's uncertainty is dynamic."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from fbfcli.papers.ramani_2020b import FOUND, REALISATIONS, SPREAD, errors, robust, standard
from fbfcli.papers.ramani_2020b_printer import compare, responses, trajectory
from fbfcli.papers.zero_sweep import POLE, noise


def test_errors_over_zeros_are_those_of_each_plant():
    y_d, u = noise(2), noise(4)[:, 2:]
    found = errors(u, y_d, 0.99)
    for j in (0, 77, REALISATIONS - 1):
        a = np.linspace(0.99 - SPREAD, 0.99 + SPREAD, REALISATIONS)[j]
        e = y_d - lfilter([1.0, -a], [1.0, -POLE], u, axis=0)
        np.testing.assert_allclose(found[j], np.linalg.norm(e, axis=0) / np.linalg.norm(y_d, axis=0), rtol=1e-9)


def test_an_unstable_robust_filter_improves_the_mean_as_in_app_a():
    """a_nom = 0.99: 42 % within three standard errors of the mean over 20 draws."""
    y_d = noise(20)
    plain, sturdy = (errors(made.command(y_d), y_d, 0.99).mean(axis=0) for made in (standard(0.99), robust(0.99)))
    mean, sd = FOUND[0.99]
    assert (100 * (1 - sturdy / plain)).mean() == pytest.approx(mean, abs=3 * sd / np.sqrt(20))


def test_robust_fbf_is_better_than_by_any_response_of_a_family():
    assert compare(responses(1)[::5], 60, 1).q.min() > 0


def test_the_trajectory_is_within_its_band():
    Y = np.abs(np.fft.rfft(trajectory(0)[:1000]))
    f = np.fft.rfftfreq(1000, 1e-3)
    assert Y[(f < 4) | (f > 51)].max() < 0.05 * Y[(f >= 5) & (f <= 50)].min()
