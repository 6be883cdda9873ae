"""Widths of beads that are known."""

from itertools import pairwise

import numpy as np
from execution_cases import DT, wandering, way
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.verify.bead import BEAD, Beads

SEEDS = st.integers(0, 2**32 - 1)


def laid(seed: int, slower: float = 1.0, more: float = 1.0, cuts=()) -> tuple[np.ndarray, np.ndarray]:
    """Widths and ways of a wandering print whose nozzle goes `slower` times the way and that pushes `more` filament."""
    whole = wandering(seed, 900, [300])
    e = 0.03 * way(whole.desired)
    nozzle, beads, found = whole.desired * slower, Beads(DT), []
    for a, b in pairwise(np.unique([0, *cuts, 900]).tolist()):
        rows = slice(a, b)
        begin = whole.begin[(whole.begin >= a) & (whole.begin < b)] - a
        columns = (whole.desired, nozzle, more * e, e, whole.extruding)
        found.append(beads.add(*(column[rows] for column in columns), begin))
    return np.concatenate([each.width for each in found]), np.concatenate([each.way for each in found])


@given(SEEDS, st.floats(0.5, 2.0), st.floats(0.5, 2.0))
def test_a_nozzle_that_goes_a_shorter_way_lays_a_wider_bead(seed, slower, more):
    width, length = laid(seed, slower, more)
    np.testing.assert_allclose(width, more / slower, rtol=1e-6)
    assert (length > 0).all()


@given(SEEDS, st.lists(st.integers(1, 899), max_size=6))
def test_cuts_change_nothing(seed, cuts):
    one, many = laid(seed, 0.9), laid(seed, 0.9, cuts=cuts)
    np.testing.assert_allclose(many[0], one[0], rtol=1e-6)
    np.testing.assert_allclose(many[1], one[1], rtol=1e-6, atol=1e-9)


def test_most_of_a_long_line_is_measured():
    x = np.linspace(0.0, 50.0, 1001)
    path = np.column_stack([x, 0 * x])
    found = Beads(DT).add(path, path, 0.03 * x, 0.03 * x, np.ones(1001, bool), np.array([0]))
    assert 50.0 - 3 * BEAD <= found.way.sum() <= 50.0 and found.rms < 1e-12
