"""Filament in step with the nozzle: totals stay, widths do, and nothing is drawn back."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.motion.filament import following

SEEDS = st.integers(0, 2**32 - 1)


def printed(seed: int, n: int = 400) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """E, path, nozzle and begins of stretches that print, travel, retract on the way, and rest."""
    rng = np.random.default_rng(seed)
    begin = np.unique(np.append(0, rng.integers(1, n, 3)))
    kind = np.repeat(rng.integers(0, 4, n // 20 + 1), 20)[:n]  # print, print thicker, travel, wipe
    step = np.where(kind[:, None] < 4, rng.normal(0, 0.1, (n, 2)), 0.0)
    step[begin] = 0.0
    per_mm = np.array([0.03, 0.05, 0.0, -0.1])[kind]
    e = 1000.0 + np.cumsum(per_mm * np.hypot(*step.T))
    path = np.cumsum(step, axis=0)
    return e, path, path + np.cumsum(rng.normal(0, 0.01, (n, 2)), axis=0), begin


@given(SEEDS)
def test_a_nozzle_on_its_path_gets_what_was_asked_for(seed):
    e, path, _, begin = printed(seed)
    np.testing.assert_allclose(following(e, path, path, begin), e, atol=1e-9)


@given(SEEDS)
def test_totals_are_exact_and_only_printing_changes(seed):
    e, path, nozzle, begin = printed(seed)
    pushed = np.diff(e, prepend=e[0]) > 1e-9
    pushed[begin] = False
    new = following(e, path, nozzle, begin)
    np.testing.assert_array_equal(new[~pushed], e[~pushed])
    ends = pushed & ~np.append(pushed[1:], False)
    np.testing.assert_array_equal(new[ends], e[ends])


@given(SEEDS)
def test_filament_is_never_drawn_back_where_it_is_pushed(seed):
    e, path, nozzle, begin = printed(seed)
    rises = np.diff(e) >= 0
    assert (np.diff(following(e, path, nozzle, begin))[rises] >= -1e-9).all()


@given(SEEDS, st.floats(0.3, 3.0))
def test_a_bead_keeps_its_width_along_a_section(seed, stretch):
    """A nozzle that goes a longer way at the same places of time gets evenly more, up to the section's total."""
    n = 100
    s = np.cumsum(np.random.default_rng(seed).uniform(0.01, 0.2, n))
    s -= s[0]
    swing = 0.01 * np.sin(stretch * np.arange(n))
    swing[[0, -1]] = 0.0
    path, nozzle = (np.column_stack([x, np.zeros(n)]) for x in (s, s + swing))
    e = following(0.04 * s, path, nozzle, np.array([0]))
    width = np.diff(e) / np.abs(np.diff(nozzle[:, 0]))
    np.testing.assert_allclose(width, width[0], rtol=1e-6)
    assert abs(e[-1] - 0.04 * s[-1]) < 1e-12


def test_without_filament_nothing_changes():
    path = np.cumsum(np.ones((50, 2)), axis=0)
    e = np.full(50, 7.0)
    np.testing.assert_array_equal(following(e, path, 2 * path, np.array([0])), e)
