"""Contour errors of paths whose errors are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.verify.contour_error import ErrorTally, contour_error

SEEDS = st.integers(0, 2**32 - 1)


def whole(actual: np.ndarray, desired: np.ndarray) -> np.ndarray:
    """Of every sample of one stretch."""
    n = len(desired)
    at = np.arange(n)
    return contour_error(actual, desired, at, np.zeros(n, int), np.full(n, n - 1))


@given(SEEDS, st.integers(2, 300))
def test_the_path_itself_has_no_error(seed, n):
    path = np.cumsum(np.random.default_rng(seed).normal(0, 0.1, (n, 2)), axis=0)
    np.testing.assert_allclose(whole(path, path), 0.0, atol=1e-12)


@given(st.floats(0, 2 * np.pi), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.01, 0.2))
def test_beside_a_straight_path_it_is_the_distance_across(angle, across, along, step):
    """Being late or early along the path is no contour error."""
    r = np.array([np.cos(angle), np.sin(angle)])
    path = np.arange(400)[:, None] * step * r
    normal = np.array([-r[1], r[0]])
    error = whole(path + across * normal + along * r, path)
    late = int(np.ceil(abs(along) / step)) + 1
    if late < 50:
        np.testing.assert_allclose(error[late : 400 - late], abs(across), atol=1e-9)


@given(st.floats(3.0, 50.0), st.floats(-0.3, 0.3), st.floats(-0.2, 0.2))
def test_beside_a_circle_it_is_the_difference_of_radii(radius, wider, turned):
    """Chords of 1 ms at 100 mm/s are off by h^2 / 8R."""
    h = 0.1
    angle = np.arange(300) * h / radius
    path = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    actual = (radius + wider) * np.column_stack([np.cos(angle + turned / radius), np.sin(angle + turned / radius)])
    error = whole(actual, path)[10:-10]
    np.testing.assert_allclose(error, abs(wider), atol=1.1 * h * h / (8 * radius) + 1e-9)


@given(SEEDS, st.integers(20, 200), st.floats(1e-3, 0.2))
def test_it_is_no_less_than_the_distance_from_the_whole_path_and_no_more_than_the_tracking_error(seed, n, size):
    rng = np.random.default_rng(seed)
    path = np.cumsum(np.cumsum(rng.normal(0, 0.02, (n, 2)), axis=0), axis=0)
    actual = path + rng.normal(0, size, (n, 2))
    error = whole(actual, path)
    assert (error <= np.hypot(*(actual - path).T) + 1e-12).all()
    assert (error >= distance(actual, path) - 1e-9).all()


def distance(points: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Exact distance of each point from the polygon."""
    a, s = path[:-1], np.diff(path, axis=0)
    rel = points[:, None] - a
    t = np.clip((rel * s).sum(-1) / np.maximum((s * s).sum(-1), 1e-30), 0, 1)
    return np.sqrt(((rel - t[..., None] * s) ** 2).sum(-1)).min(axis=1)


@given(SEEDS, st.floats(1e-3, 0.05))
def test_near_a_smooth_path_it_is_the_distance_from_it(seed, size):
    rng = np.random.default_rng(seed)
    angle = np.cumsum(np.cumsum(rng.normal(0, 0.002, 200)))
    path = np.cumsum(0.1 * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    actual = path + rng.normal(0, size, path.shape)
    found, exact = whole(actual, path), distance(actual, path)
    assert np.quantile(found - exact, 0.95) <= 1e-6, "a path that crosses itself may pass nearer at another time"


def test_a_stretch_ends_at_its_own_samples():
    """The next stretch passes through the point, later: that is another line on the part."""
    desired = np.array([[0.0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]])
    actual = desired.copy()
    actual[1] = [1.0, 1.0]
    at, first, last = np.array([1]), np.array([0]), np.array([2])
    assert contour_error(actual, desired, at, first, last) == pytest.approx([1.0])


@given(st.lists(st.floats(0, 4.0), min_size=1, max_size=300), st.integers(1, 20))
def test_figures_in_pieces_are_those_of_all_errors(errors, size):
    errors = np.array(errors)
    tally = ErrorTally()
    for k in range(0, len(errors), size):
        tally.add(errors[k : k + size])
    found = tally.figures()
    assert found["rms"] == pytest.approx(1e3 * np.sqrt(np.mean(errors**2)), rel=1e-9, abs=1e-9)
    assert found["max"] == pytest.approx(1e3 * errors.max())
    p99 = np.sort(errors)[int(np.ceil(0.99 * len(errors))) - 1]
    assert found["p99"] == pytest.approx(1e3 * p99, abs=1e3 * 1.01 * ErrorTally.BIN_MM)


def test_nothing_counted_is_no_error():
    assert ErrorTally().figures() == {"rms": 0.0, "p99": 0.0, "max": 0.0}
