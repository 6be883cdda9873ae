"""The curve between samples: through them, within them, and smooth."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from step_cases import motions

from fbfcli.steps.curve import position


@given(motions())
def test_it_goes_through_every_sample(x):
    assert np.allclose(position(x, np.arange(len(x), dtype=float)), x, rtol=0, atol=1e-12)


@given(motions())
def test_it_never_leaves_the_two_samples_around(x):
    at = np.linspace(0, len(x) - 1, 17 * len(x))[:-1]
    y, k = position(x, at), at.astype(int)
    low, high = np.minimum(x[k], x[k + 1]), np.maximum(x[k], x[k + 1])
    assert (y >= low - 1e-9).all()
    assert (y <= high + 1e-9).all()


@given(motions())
def test_it_is_continuous_in_speed(x):
    step = 1e-5
    k = np.arange(2, 2 * len(x) - 4) / 2.0  # samples and middles
    before = (position(x, k) - position(x, k - step)) / step
    after = (position(x, k + step) - position(x, k)) / step
    assert np.allclose(before, after, rtol=0, atol=1e-3)  # 2 bend step + rounding


def test_a_constant_acceleration_is_met_exactly():
    k = np.arange(50.0)
    at = np.linspace(1, 48, 777)
    assert np.allclose(position(0.3 * k * k + 5.0 * k, at), 0.3 * at * at + 5.0 * at, rtol=0, atol=1e-10)


def test_columns_are_curves_of_their_own():
    x = np.cumsum(np.random.default_rng(1).normal(size=(40, 3)), axis=0)
    at = np.linspace(0, 39, 200)
    assert (position(x, at)[:, 1] == position(x[:, 1], at)).all()
