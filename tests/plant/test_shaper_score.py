"""Klipper's choice of a shaper, scored as Klipper scores it."""

from __future__ import annotations

import numpy as np
import pytest
from resonance_corpus import RESONANCE, needs_resonance
from response_cases import ONE

from fbfcli.control.shapers import impulses
from fbfcli.plant import shaper_score
from fbfcli.plant.rational import response
from fbfcli.plant.shaper_score import best_shaper, klipper_spectrum, most_acceleration, normalised, smoothing


def test_a_lone_mode_gets_a_shaper_at_its_frequency():
    f = np.arange(1.0, 201.0, 1.5)
    best, kinds = best_shaper(f, f * np.abs(response(ONE, f)) ** 2, impulses)
    assert [kind.name for kind in kinds] == ["zv", "mzv", "ei", "2hump_ei", "3hump_ei"]
    assert abs(best.frequency / 38.0 - 1) < 0.2
    assert best.vibrations < 0.05


def test_longer_shapers_smooth_more_and_suggest_less_acceleration():
    values = [impulses(name, 40.0, 0.1) for name in ("zv", "mzv", "ei", "2hump_ei", "3hump_ei")]
    smooth = [smoothing(A, T, 5000.0) for A, T in values]
    assert smooth == sorted(smooth)
    suggested = [most_acceleration(A, T) for A, T in values]
    assert suggested == sorted(suggested, reverse=True)
    assert all(smoothing(*v, a) == pytest.approx(0.12, abs=1e-6) for v, a in zip(values, suggested, strict=True))


def impulses_of_2023(name: str, f: float, zeta: float) -> tuple[np.ndarray, np.ndarray]:
    """A, T as Klipper defined its shapers until 2024: the EI family half periods apart, weights of the undamped case
    times K per half period (Singhose et al. 1997 for two and three humps, V: vibration tolerated)."""
    if name in ("zv", "mzv"):
        return impulses(name, f, zeta)
    V, root = 0.05, np.sqrt(1 - zeta**2)
    if name == "ei":
        weights = [(1 + V) / 4, (1 - V) / 2, (1 + V) / 4]
    elif name == "2hump_ei":
        X = np.cbrt(V**2 * (np.sqrt(1 - V**2) + 1))
        outer = (3 * X**2 + 2 * X + 3 * V**2) / (16 * X)
        weights = [outer, 0.5 - outer, 0.5 - outer, outer]
    else:
        outer, second = (1 + 3 * V + 2 * np.sqrt(2 * V * (V + 1))) / 16, (1 - V) / 4
        weights = [outer, second, 1 - 2 * (outer + second), second, outer]
    halves = np.arange(len(weights))
    A = np.array(weights) * np.exp(-zeta * np.pi / root * halves)
    return A / A.sum(), halves * 0.5 / (f * root)


TOLD = {"zv": 52.6, "mzv": 54.2, "ei": 64.8, "2hump_ei": 80.6, "3hump_ei": 96.2}  # the file's heading


@pytest.fixture
def of_2023():
    """f, psd and the response of each shaper that Klipper chose, from a file of March 2023."""
    file = RESONANCE / "klipper_psd" / "bassco_v24_calibration_data_x_20230306_225431.csv"
    table = np.genfromtxt(file, delimiter=",", skip_header=1)
    return table[:, 0], table[:, 4], table[:, 5:]


@needs_resonance
def test_klipper_s_own_answer_is_found_in_its_file(of_2023, monkeypatch):
    """All five kinds, to the step, with the shapers and the rule of the file's time: no vibration was tolerated yet."""
    f, psd, _ = of_2023
    monkeypatch.setattr(shaper_score, "TOLERATED", 0.0)
    best, kinds = best_shaper(f, psd, impulses_of_2023)
    assert {kind.name: kind.frequency for kind in kinds} == pytest.approx(TOLD, abs=1e-6)
    assert best.name == "mzv"


@needs_resonance
def test_the_file_s_shapers_are_those_of_its_time(of_2023):
    """What a shaper leaves at each frequency stands in the file: today's EI family is another, the rest is the same."""
    f, _, left = of_2023
    for column, (name, frequency) in zip(left.T, TOLD.items(), strict=True):
        old, new = (
            np.max([shaper_score.residual(*made(name, frequency, 0.1), z, f) for z in shaper_score.DAMPINGS], axis=0)
            for made in (impulses_of_2023, impulses)
        )
        assert np.abs(old - column).max() < 0.002  # f is told in steps of 0.1 Hz
        assert (np.abs(new - column).max() < 0.002) == (name in ("zv", "mzv"))


def test_the_spectrum_is_of_power_per_hz():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((64_000, 3))
    f, psd = klipper_spectrum(noise, 3200.0)
    assert psd[5:-5].mean() == pytest.approx(3 * 2 / 3200.0, rel=0.05)
    assert (normalised(f, psd)[f > 20] == psd[f > 20] / (f[f > 20] + 0.1)).all()
