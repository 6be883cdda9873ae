"""A path remembers which plants each of its samples came under, however it is put together and cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from fbfcli.control.path import Path, resting

pieces = st.lists(st.tuples(st.integers(0, 5), st.integers(0, 2)), min_size=1, max_size=8)


def built(parts: list[tuple[int, int]]) -> tuple[Path, list[int]]:
    """A path of the pieces, and the model of each sample."""
    path, under = resting(1, 2, 0), [0, 0]
    for count, model in parts:
        path = path.then(np.full((1, count), float(len(under))), np.ones(count), model)
        under += [model] * count
    return path, under


def models(path: Path) -> list[int]:
    """The model of each sample, from the path's changes."""
    return [[m for start, m in path.models if start <= k][-1] for k in range(len(path.weight))]


@given(pieces, st.integers(0, 20), st.integers(0, 20))
def test_every_sample_keeps_its_model(parts, a, b):
    path, under = built(parts)
    assert models(path) == under
    assert models(path[a : a + b]) == under[a : a + b]
    assert models(path[a:][b:]) == under[a + b :]
    assert_array_equal(path[a:][b:].y, path.y[:, a + b :])


@given(pieces, st.integers(0, 20))
def test_what_is_past_is_forgotten(parts, a):
    path, _ = built(parts)
    assert sum(start <= 0 for start, _ in path[a:].models) == 1
    assert all(first != second for (_, first), (_, second) in pairwise(path.models))
