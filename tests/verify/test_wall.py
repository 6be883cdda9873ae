"""The wall that is shown, and its roughness where it is known."""

from itertools import pairwise

import numpy as np
import pytest
from execution_cases import DT, RIGID, cut, execution, mode
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.verify.passages import Passages
from fbfcli.verify.wall import STEP, Wall, Walls

FEATURES = ["unknown", "Internal infill", "External perimeter"]


def sides(lengths, v: float = 100.0) -> np.ndarray:
    """A path that goes on along X and Y by turns."""
    x, steps = np.zeros(2) + 20.0, []
    for i, length in enumerate(lengths):
        s = np.arange(0.0, length, v * DT)[:, None]
        r = np.array([1.0, 0.0] if i % 2 == 0 else [0.0, 1.0])
        steps.append(x + s * r)
        x = x + length * r
    return np.vstack([*steps, x])


def walls(plants, pieces, features=FEATURES) -> tuple[Wall, ...]:
    machine, found = Passages(plants), Walls(features)
    for passage in [*(machine.add(piece) for piece in pieces), machine.finish()]:
        if passage is not None:
            found.add(passage)
    return found.found()


def test_the_longest_of_each_direction_is_shown():
    x, y = walls(RIGID, [execution(sides([20, 30, 40, 25, 15]))])[::-1]
    assert x.axis == 1 and x.length == pytest.approx(40.0, abs=0.3)
    assert y.axis == 0 and y.length == pytest.approx(30.0, abs=0.3)
    assert x.along[1] - x.along[0] == pytest.approx(STEP) and max(x.roughness.values()) < 1e-6


def test_an_outer_wall_comes_before_a_longer_line_of_infill():
    path = sides([20, 30, 40, 25])
    feature = np.where(np.arange(len(path)) < 490, 2, 1)
    assert [wall.feature for wall in walls(RIGID, [execution(path, feature=feature)])] == [2, 2]


def test_the_wall_shows_the_waves_that_the_corner_before_it_excites():
    """Wavelength is speed / frequency, and Ra of a sine is 2 / pi of its amplitude, Rq its 1 / sqrt 2."""
    wall = walls(mode(40.0, 0.003), [execution(sides([60, 30]))])[0]
    crossings = np.flatnonzero(wall.off[1:] * wall.off[:-1] < 0)
    assert 2 * np.diff(crossings).mean() * STEP == pytest.approx(100.0 / 40.0, rel=0.02)
    z = wall.off - wall.off.mean()
    assert wall.roughness["Rq"] == pytest.approx(1e3 * z.max() / np.sqrt(2), rel=0.2)
    assert wall.roughness["Ra"] == pytest.approx(1e3 * z.max() * 2 / np.pi, rel=0.2)
    assert wall.roughness["Rz"] == pytest.approx(2e3 * z.max(), rel=0.2)


@settings(max_examples=25)
@given(st.lists(st.integers(1, 899), max_size=5))
def test_cuts_change_nothing(cuts):
    path = sides([20, 30, 40])
    whole = execution(path, line=np.arange(len(path)))
    pieces = [cut(whole, a, b) for a, b in pairwise(np.unique([0, *cuts, len(path)]).tolist())]
    one, many = (walls(mode(40.0, 0.1), parts) for parts in ([whole], pieces))
    assert [w.line for w in one] == [w.line for w in many]
    for a, b in zip(one, many, strict=True):
        np.testing.assert_allclose(b.off, a.off, atol=1e-9)


@pytest.mark.parametrize("by_turns", (False, True))
def test_another_method_shows_the_same_walls_on_its_own_clock(by_turns):
    """Of many alike walls, whichever is the longest by a hair of sampling, the first method's is shown."""
    lengths = [20, 30, 20, 30, 20, 30, 20, 30]
    paths = [sides(lengths, v) for v in (100.0, 97.0)]
    first, second = (execution(path, line=np.arange(len(path)) // 100) for path in paths)
    before = Walls(FEATURES)
    after = Walls(FEATURES, before)
    runs = [(before, Passages(mode(40.0, 0.1)), first), (after, Passages(mode(40.0, 0.1)), second)]
    cuts = [[0, len(e) // 2, len(e)] for _, _, e in runs]
    order = [(i, k) for k in range(3) for i in range(2)] if by_turns else [(i, k) for i in range(2) for k in range(3)]
    for i, k in order:
        found, machine, whole = runs[i]
        passage = machine.finish() if k == 2 else machine.add(cut(whole, cuts[i][k], cuts[i][k + 1]))
        if passage is not None:
            found.add(passage)
    assert len(before.found()) == 2 == len(after.found())
    for a, b in zip(before.found(), after.found(), strict=True):
        assert a.axis == b.axis and np.hypot(*(a.begin - b.begin)) < 1.0 and np.hypot(*(a.end - b.end)) < 1.0
