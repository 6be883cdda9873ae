"""Klipper's choice of a shaper, scored as Klipper scores it."""

from __future__ import annotations

import numpy as np
import pytest
from response_cases import ONE

from fbfcli.control.shapers import impulses
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


def test_klipper_s_own_answer_is_found_in_its_file(root):
    spectra = root.parent / "shared" / "corpus" / "resonance" / "klipper_psd"
    file = spectra / "bassco_v24_calibration_data_x_20230306_225431.csv"
    if not file.exists():
        pytest.skip("the corpus is not here")
    told = {"zv": 52.6, "mzv": 54.2}  # of its heading; its EI family lies 2 to 11 Hz lower, why is not known
    table = np.genfromtxt(file, delimiter=",", skip_header=1, usecols=(0, 4))
    best, kinds = best_shaper(table[:, 0], table[:, 1], impulses)
    assert {kind.name: kind.frequency for kind in kinds if kind.name in told} == pytest.approx(told, abs=0.5)
    assert best.name == "mzv"


def test_the_spectrum_is_of_power_per_hz():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((64_000, 3))
    f, psd = klipper_spectrum(noise, 3200.0)
    assert psd[5:-5].mean() == pytest.approx(3 * 2 / 3200.0, rel=0.05)
    assert (normalised(f, psd)[f > 20] == psd[f > 20] / (f[f > 20] + 0.1)).all()
