"""Errors of a streamed print: those of the whole, however it is cut, and those that are known."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from execution_cases import DT, RIGID, cut, execution, joined, mode, row_names, wandering
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.verify.contour_error import contour_error
from fbfcli.verify.heading import Heading, moving
from fbfcli.verify.passage import Passage
from fbfcli.verify.passages import Passages

SEEDS = st.integers(0, 2**32 - 1)
STARTS = st.lists(st.integers(1, 899), max_size=4)


def passage(plants, pieces) -> Passage:
    machine = Passages(plants)
    found = [machine.add(piece) for piece in pieces]
    return joined([each for each in [*found, machine.finish()] if each is not None])


@given(SEEDS, STARTS)
def test_a_rigid_machine_has_no_error(seed, starts):
    found = passage(RIGID, [wandering(seed, 900, starts)])
    for error in (found.tracking, found.contour, found.across, found.along):
        np.testing.assert_allclose(error, 0.0, atol=1e-9)


@given(SEEDS, STARTS)
def test_along_and_across_make_up_the_tracking_error_and_the_contour_error_is_no_larger(seed, starts):
    found = passage(mode(40.0, 0.1), [wandering(seed, 900, starts)])
    headed = slice(int(moving(found.execution.desired, DT)[1][1:].argmax()) + 1, None)  # it has a direction
    parts = np.hypot(found.along, found.across)
    np.testing.assert_allclose(parts[headed], found.tracking[headed], rtol=1e-9, atol=1e-12)
    assert (found.contour <= found.tracking + 1e-12).all()
    assert (np.abs(found.contour) > 1e-6).any()


@settings(max_examples=60)
@given(SEEDS, STARTS, st.lists(st.integers(1, 899), max_size=6))
def test_cuts_change_nothing(seed, starts, cuts):
    """At every sample the errors of a print in one piece, and every sample once."""
    whole = wandering(seed, 900, starts)
    pieces = [cut(whole, a, b) for a, b in pairwise(np.unique([0, *cuts, 900]).tolist())]
    one, many = (passage(mode(40.0, 0.1), parts) for parts in ([whole], pieces))
    for name in ("nozzle", "tracking", "contour", "across", "along"):
        np.testing.assert_allclose(getattr(many, name), getattr(one, name), rtol=0, atol=1e-9, err_msg=name)
    for name in ("begin", "rest", *row_names()):
        np.testing.assert_array_equal(getattr(many.execution, name), getattr(whole, name), err_msg=name)
    assert not many.execution.goes_on


def test_a_passage_goes_on_where_its_last_stretch_is_not_at_its_end():
    """Held back: the last samples of a stretch, or all of one that has just begun."""
    whole = wandering(1, 900, [600])
    for end, goes_on, length in ((620, False, 600), (590, True, 590 - 64), (600, False, 600), (800, True, 800 - 64)):
        machine = Passages(RIGID)
        first = machine.add(cut(whole, 0, end))
        assert first is not None and (len(first), first.execution.goes_on) == (length, goes_on)
        second = machine.add(cut(whole, end, 900))
        assert second is not None and len(second) == 900 - length and not second.execution.goes_on
        assert machine.finish() is None


@given(st.floats(0, 2 * np.pi), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_ahead_and_left_are_positive(angle, ahead, left):
    r = np.array([np.cos(angle), np.sin(angle)])
    path = 50.0 + np.arange(400)[:, None] * 0.05 * r
    moved = path + ahead * r + left * np.array([-r[1], r[0]])
    whole = execution(path)
    moved[0] = path[0]  # it has no direction yet
    found = passage(RIGID, [replace(whole, motion=np.column_stack([moved, whole.motion[:, 2:]]))])
    np.testing.assert_allclose(found.along[1:], ahead, atol=1e-9)
    np.testing.assert_allclose(found.across[1:], left, atol=1e-9)


def test_a_path_that_stands_has_the_direction_it_came_in():
    x = np.concatenate([np.zeros(5), np.arange(1, 6), np.full(5, 5.0)])
    path = np.column_stack([x, 0 * x])
    turned = np.vstack([path, path[-1] + path[:, ::-1]])
    heading = Heading(1e-3).follow(turned, np.array([0, 15]))
    np.testing.assert_allclose(heading[:5], 0.0)
    np.testing.assert_allclose(heading[5:20], [[1.0, 0.0]] * 15)
    np.testing.assert_allclose(heading[20:], [[0.0, 1.0]] * 10)


@settings(max_examples=20)
@given(SEEDS, st.sampled_from((2e-4, 1e-4)))
def test_finer_samples_have_the_distance_from_the_whole_path(seed, dt):
    """Near a path of bends of 1 mm and more: the distance from the nearest of all its segments."""
    rng = np.random.default_rng(seed)
    angle = np.cumsum(rng.uniform(-0.1, 0.1, 80))
    nodes = np.cumsum(0.1 * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    k = np.arange(0, 79, dt / 1e-3)
    path = np.column_stack([np.interp(k, np.arange(80), column) for column in nodes.T])
    actual = path + 0.1 * np.column_stack([np.sin(0.3 * k), np.cos(0.2 * k)])
    at = np.arange(0, len(path), 7)
    a, s = path[:-1], np.diff(path, axis=0)
    t = np.clip(((actual[at, None] - a) * s).sum(axis=2) / (s * s).sum(axis=1), 0, 1)
    brute = np.linalg.norm(actual[at, None] - a - t[:, :, None] * s, axis=2).min(axis=1)
    found = contour_error(actual, path, at, np.zeros(len(at), int), np.full(len(at), len(path) - 1), dt)
    np.testing.assert_allclose(found, brute, rtol=0, atol=1e-9)


def test_nothing_of_nothing():
    machine = Passages(RIGID)
    assert machine.add(execution(np.zeros((0, 2)), begin=())) is None and machine.finish() is None
