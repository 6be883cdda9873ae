"""Arcs and splines: chords stay within the tolerance, end where they should, and have the right length."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from reading_cases import moves_of

from fbfcli.errors import GcodeError
from fbfcli.gcode.arcs import LONGEST_MM, TOLERANCE_MM, arc_centres, chord_arcs, chord_splines

radii = st.floats(0.01, 80)
angles = st.floats(-3.1, 3.1)
turns = st.floats(0.01, 6.27)
places = st.floats(-100, 100)


def arc(radius, angle, turn, clockwise, x=0.0, y=0.0, climb=0.0, extrude=0.0):
    """(start, end, centre, clockwise) of one arc, as arrays of one."""
    after = angle + (-turn if clockwise else turn)
    start = [x + radius * np.cos(angle), y + radius * np.sin(angle), 0.0, 0.0]
    end = [x + radius * np.cos(after), y + radius * np.sin(after), climb, extrude]
    return np.array([start]), np.array([end]), np.array([[x, y]]), np.array([clockwise])


@given(radii, angles, turns, st.booleans(), places, places, st.floats(-5, 5), st.floats(0, 5))
def test_chords_follow_the_circle(radius, angle, turn, clockwise, x, y, climb, extrude):
    assume(radius * turn > 1e-3)
    start, end, centre, direction = arc(radius, angle, turn, clockwise, x, y, climb, extrude)
    chords = chord_arcs(start, end, centre, direction)
    points = chords.start + chords.delta
    np.testing.assert_allclose(points[-1], end[0], rtol=0, atol=1e-12)
    assert chords.start[0].tolist() == start[0].tolist()
    np.testing.assert_allclose(np.hypot(*(points[:, :2] - centre).T), radius, atol=1e-9)
    middle = chords.start[:, :2] + chords.delta[:, :2] / 2 - centre
    assert np.all(radius - np.hypot(*middle.T) <= TOLERANCE_MM * (1 + 1e-6))
    length = np.hypot(*chords.delta[:, :2].T)
    assert np.all(length <= LONGEST_MM + 1e-9)
    assert radius * turn * (1 - 0.11) <= length.sum() <= radius * turn * (1 + 1e-9) + 1e-9
    np.testing.assert_allclose(chords.delta[:, 2], climb / len(chords.delta), atol=1e-9)
    np.testing.assert_allclose(chords.delta[:, 3], extrude / len(chords.delta), atol=1e-9)
    (ax, ay), (bx, by) = (chords.start[:, :2] - centre).T, (points[:, :2] - centre).T
    assert np.all((ax * by - ay * bx < 0) == clockwise)


@given(st.floats(0.1, 50), angles, st.floats(0.1, 6.2), st.booleans())
def test_radius_and_offset_say_the_same(radius, angle, turn, clockwise):
    assume(abs(turn - np.pi) > 0.05)
    start, end, centre, direction = arc(radius, angle, turn, clockwise)
    none = np.array([np.nan])
    r = np.array([radius if turn < np.pi else -radius])  # R below zero takes the longer way
    np.testing.assert_allclose(arc_centres(start, end, none, none, r, direction), centre, atol=1e-6 * radius)
    i, j = (centre - start[:, :2]).T
    np.testing.assert_allclose(arc_centres(start, end, i, j, none, direction), centre, atol=1e-12)


@given(st.lists(st.tuples(radii, angles, turns, st.booleans()), min_size=1, max_size=6))
def test_many_arcs_at_once_are_each_arc_alone(cases):
    columns = [np.concatenate(column) for column in zip(*(arc(*case) for case in cases), strict=True)]
    together = chord_arcs(*columns)
    alone = [chord_arcs(*arc(*case)) for case in cases]
    assert together.count.tolist() == [int(one.count[0]) for one in alone]
    np.testing.assert_array_equal(together.delta, np.concatenate([one.delta for one in alone]))


@given(st.lists(places, min_size=8, max_size=8))
def test_splines_follow_the_curve(numbers):
    p0, p1, p2, p3 = np.array(numbers).reshape(4, 2)
    start, end = np.array([[*p0, 0, 0]]), np.array([[*p3, 1, 2]])
    chords = chord_splines(start, end, (p1 - p0)[None], (p2 - p3)[None])
    points = chords.start + chords.delta
    np.testing.assert_allclose(points[-1], end[0], rtol=0, atol=1e-12)
    n = len(points)
    t = (np.arange(n)[:, None] + 0.5) / n
    curve = (1 - t) ** 3 * p0 + 3 * (1 - t) ** 2 * t * p1 + 3 * (1 - t) * t**2 * p2 + t**3 * p3
    error = curve - chords.start[:, :2] - chords.delta[:, :2] / 2
    assert np.all(np.hypot(*error.T) <= TOLERANCE_MM * (1 + 1e-6) + 1e-9)


def test_full_circle_and_helix():
    moves = moves_of("G1 X10 Y0 F600\nG2 I-10 E5\nG3 Z.8 I-2 J1 P1 F30000")
    circle, helix = moves.line == 1, moves.line == 2
    assert np.hypot(*moves.delta[circle, :2].T).sum() == pytest.approx(20 * np.pi, rel=1e-4)
    assert moves.delta[circle, 3].sum() == pytest.approx(5)
    assert np.abs(moves.delta[helix, :3].sum(axis=0) - [0, 0, 0.8]).max() < 1e-12
    assert np.hypot(*moves.delta[helix, :2].T).sum() == pytest.approx(2 * np.pi * np.sqrt(5), rel=1e-3)


def test_offsets_are_from_the_start_in_relative_coordinates_too():
    absolute, relative = moves_of("G1 X5 Y5 F60\nG3 X6 Y6 I1"), moves_of("G91\nG1 X5 Y5 F60\nG3 X1 Y1 I1")
    np.testing.assert_allclose(relative.delta, absolute.delta, atol=1e-12)


def test_an_end_off_the_circle_is_reached_by_a_straight_line():
    moves = moves_of("G1 X0 Y0 Z10 F60\nG2 X15 Y20 I30 J40 Z20")
    radius = np.hypot(*(moves.start[1:, :2] - [30, 40]).T)
    np.testing.assert_allclose(radius[moves.line[1:] == 1], 50, atol=1e-9)
    assert (moves.start + moves.delta)[-1, :3].tolist() == [15, 20, 20]


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("G2 X5 Y5", "needs I, J or R"), ("G2 X5 I0 J0", "radius"), ("G2 R5", "elsewhere"), ("G3 X50 R5", "twice R"),
        ("G2 I1 P2", "turns"), ("G5 X5 Y5 I1 J1", "P and Q"), ("G2 I9999999", "too long"),
    ],
)  # fmt: skip
def test_impossible_arcs_are_refused_with_their_line(line, why):
    with pytest.raises(GcodeError, match=why) as caught:
        moves_of(f"G1 X1 Y1 F600\nG1 X2\n{line}\n")
    assert caught.value.line == 3


@pytest.mark.parametrize("plane", ["G18", "G19"])
def test_other_planes_are_refused(plane):
    with pytest.raises(GcodeError, match="plane"):
        moves_of(f"G1 X1 F600\n{plane}\nG2 X5 I1")
    assert len(moves_of(f"{plane}\nG1 X1 F600\nG17\nG2 X5 I2")) > 2
