"""Thinning leaves out what nobody would see, and invents nothing."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.verify.thinning import thinned


def curve(seed: int, n: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).normal(0, 0.05, (n, 3)), axis=0)


def off(x: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Distance of each row from the chord between the kept rows around it, one by one."""
    worst = []
    for a, b in pairwise(kept.tolist()):
        span = x[b] - x[a]
        for k in range(a + 1, b):
            share = np.clip((x[k] - x[a]) @ span / max(span @ span, 1e-300), 0, 1)
            worst.append(np.linalg.norm(x[k] - x[a] - share * span))
    return np.array(worst)


@given(st.integers(0, 2**32 - 1), st.integers(1, 120), st.floats(1e-3, 1.0), st.lists(st.integers(0, 119), max_size=4))
def test_what_is_left_out_is_within_the_tolerance_of_what_stays(seed, n, tolerance, seeds):
    x, seeds = curve(seed, n), np.array([k for k in seeds if k < n], dtype=np.int64)
    kept = thinned(x, seeds, tolerance)
    assert (np.diff(kept) > 0).all() and {0, n - 1, *seeds.tolist()} <= set(kept.tolist())
    assert (off(x, kept) <= tolerance * (1 + 1e-9)).all()


@given(st.integers(0, 2**32 - 1), st.integers(2, 200), st.floats(1e-3, 1.0))
def test_a_coarser_tolerance_keeps_some_of_the_same_points(seed, n, tolerance):
    x, none = curve(seed, n), np.zeros(0, dtype=np.int64)
    assert set(thinned(x, none, 2 * tolerance)) <= set(thinned(x, none, tolerance))


def test_a_straight_line_needs_its_ends_and_nothing_at_all_needs_nothing():
    none = np.zeros(0, dtype=np.int64)
    assert thinned(np.linspace([0, 0], [30, 40], 10_000), none, 1e-6).tolist() == [0, 9_999]
    assert thinned(np.zeros((0, 2)), none, 1.0).tolist() == []
    assert thinned(np.ones((500, 2)), none, 1e-9).tolist() == [0, 499]
