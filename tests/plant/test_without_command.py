"""Recordings without a command: modes of a spectrum and of a free decay, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from response_cases import ONE, TWO

from fbfcli.errors import ModelError
from fbfcli.plant.acceleration_error import difference, following_error, most_acceleration
from fbfcli.plant.free_decay import free_decay
from fbfcli.plant.model import plant_of
from fbfcli.plant.power_fit import power_fit
from fbfcli.plant.rational import profile_model, response


@pytest.mark.parametrize("rise", [1.0, 2.0])
@pytest.mark.parametrize("truth", [ONE, TWO])
def test_modes_of_a_spectrum(truth, rise):
    rng = np.random.default_rng(0)
    f = np.arange(10.0, 140.0, 0.8)
    power = 7e3 * np.abs(response(truth, f)) ** 2 * f**rise * rng.chisquare(60, len(f)) / 60
    best = power_fit(f, power, rise)[0]
    found = sorted((r.frequency, r.damping) for r in best.model.resonances)
    true = sorted((r.frequency, r.damping) for r in truth.resonances)
    assert np.allclose(found, true, rtol=0.1)
    assert sum(r.gain for r in best.model.resonances) == pytest.approx(1.0)


def test_a_flat_spectrum_has_no_modes():
    f = np.arange(10.0, 140.0, 0.8)
    with pytest.raises(ModelError, match="no peak"):
        power_fit(f, f**2, 2.0)
    with pytest.raises(ModelError, match="lines"):
        power_fit(f[:5], f[:5], 2.0)


def ringing(fs=1340.0, seconds=1.2, noise=20.0):
    t = np.arange(int(fs * seconds)) / fs
    rng = np.random.default_rng(1)
    y = sum(
        a * np.exp(-z * 2 * np.pi * f * t) * np.cos(2 * np.pi * f * np.sqrt(1 - z**2) * t)
        for f, z, a in ((34.0, 0.04, 1500.0), (71.0, 0.03, 700.0))
    )
    return y + noise * rng.standard_normal(len(t)), fs


def test_modes_of_a_machine_that_rings_down():
    found = free_decay(*ringing())
    frequencies = sorted(r.frequency for r in found.model.resonances)
    assert np.allclose(frequencies, [34.0, 71.0], rtol=0.005)
    strongest = found.modes[0]
    assert strongest.damping.value == pytest.approx(0.04, rel=0.1)
    assert found.explained > 0.95


def test_what_does_not_ring_down_is_refused():
    t = np.arange(2000) / 1000.0
    rng = np.random.default_rng(2)
    for y, why in (
        (np.sin(2 * np.pi * 30 * t), "does not ring down"),
        (rng.standard_normal(2000), "does not ring down"),
        (np.ones(30), "too short"),
    ):
        with pytest.raises(ModelError, match=why):
            free_decay(y, 1000.0)


def test_acceleration_within_an_error_is_that_of_the_simulated_swing():
    """A step of acceleration through a lone mode swings to nearly twice a / w^2."""
    plant = plant_of(profile_model(ONE, 1e-3), 1e-3, "X")
    w = 2 * np.pi * 38.0
    peak = 1 / w**2 * (1 + np.exp(-np.pi * 0.05))
    assert most_acceleration([following_error(plant)], 0.05) == pytest.approx(0.05 / peak, rel=0.03)


def test_a_certain_model_allows_any_acceleration():
    plant = plant_of(profile_model(ONE, 1e-3), 1e-3, "X")
    assert most_acceleration([difference(plant, plant)], 0.05) == float("inf")
