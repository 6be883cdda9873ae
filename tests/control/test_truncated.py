"""Responses cut short: what slow motion sees of them stays."""

from __future__ import annotations

import numpy as np
import pytest
from control_cases import DT, PLANTS
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fbfcli.control.truncated import truncated
from fbfcli.plant.model import impulse_response, plant_of
from fbfcli.printer import ModalModel, Mode

K = np.arange(20_000)


def moments(h: np.ndarray) -> list[float]:
    return [float(K[: len(h)] ** q @ h) for q in range(3)]


@given(f=st.floats(15, 120), zeta=st.floats(0.02, 0.3), gain=st.floats(0.3, 1.0), f2=st.floats(20, 150))
@settings(max_examples=25, deadline=None)
def test_the_answer_to_rest_speed_and_acceleration_stays(f, zeta, gain, f2):
    modes = (Mode(f, zeta, gain), Mode(f2, zeta, 1.0 - gain)) if gain < 0.99 else (Mode(f, zeta),)
    h = impulse_response(plant_of(ModalModel(modes), DT, "x"))
    short = truncated(h)
    assert len(short) < len(h)
    assert_allclose(moments(short), moments(h), rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("name", list(PLANTS))
def test_slow_frequencies_are_answered_alike(name):
    """Up to a fifth of the first mode the cut changes the response by less than 2 %."""
    h = impulse_response(PLANTS[name])
    f = np.arange(1, 6)
    waves = np.exp(-2j * np.pi * np.outer(f, K) * DT)
    short = truncated(h)
    assert np.abs(waves[:, : len(short)] @ short - waves[:, : len(h)] @ h).max() < 0.02


def test_what_is_short_already_stays_as_it_is():
    h = np.array([0.2, 0.5, 0.3])
    assert truncated(h) is h
