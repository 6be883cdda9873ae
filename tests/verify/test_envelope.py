"""An envelope says what a curve did, however long it was and however it came."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.verify.envelope import STEPS, Enveloped


def enveloped(time: np.ndarray, x: np.ndarray, cuts: list[int], width: float = 0.01):
    found = Enveloped(x.shape[1], width)
    for rows in np.split(np.arange(len(time)), sorted(cut for cut in cuts if cut < len(time))):
        found.add(time[rows], x[rows])
    return found.envelope()


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3000), st.floats(0.1, 1e4), st.lists(st.integers(0, 2999), max_size=5))
def test_extremes_and_power_are_those_of_the_samples_in_any_pieces(seed, n, seconds, cuts):
    rng = np.random.default_rng(seed)
    time, x = np.sort(rng.uniform(0, seconds, n)), rng.normal(0, 3, (n, 2))
    found, whole = enveloped(time, x, cuts), enveloped(time, x, [])
    assert len(found.begin) <= STEPS and found.begin[-1] + found.width > time[-1]
    for name in ("begin", "low", "high", "rms"):
        np.testing.assert_allclose(getattr(found, name), getattr(whole, name), rtol=1e-9)
    np.testing.assert_array_equal(found.low.min(axis=0), x.min(axis=0))
    np.testing.assert_array_equal(found.high.max(axis=0), x.max(axis=0))
    step = np.floor(time / found.width).astype(int)
    for k, begin in enumerate(found.begin):
        here = x[step == round(begin / found.width)]
        assert found.rms[k] == pytest.approx(np.sqrt((here**2).mean(axis=0)))


def test_steps_without_a_sample_are_left_out():
    found = enveloped(np.array([0.0, 5.0]), np.ones((2, 1)), [])
    assert len(found.begin) == 2 and found.begin[1] == pytest.approx(5.0, abs=found.width)
