"""What is kept of a print for its pictures is of the print, holds its worst, and stays small."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trace_cases import DT, LAYER, SIDE, SPEED, pieces, square

from fbfcli.verify.close_ups import APART_MM
from fbfcli.verify.traces import Kept, Traces

CUTS = st.lists(st.integers(1, 4 * LAYER), max_size=4)


def kept(passages, points: int = 100_000, corners: int = 4) -> Kept:
    """Of {method: pieces}, one method after the other."""
    traces = Traces(points, corners)
    for name, parts in passages.items():
        for part in parts:
            traces.add(name, part)
    return traces.kept()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), CUTS, st.sampled_from((200, 1_000, 100_000)))
def test_points_kept_are_points_of_the_passage_and_each_layers_worst_is_among_them(seed, layers, cuts, points):
    passage = square(layers, 0.2, seed)
    found = kept({"none": pieces(passage, cuts)}, points)
    e = passage.execution
    there = {tuple(row) for row in np.column_stack([passage.nozzle, passage.contour, e.line])[e.extruding].tolist()}
    path = {tuple(row) for row in e.desired[e.extruding].tolist()}
    for layer in found.layers:
        nozzle = layer.nozzle["none"]
        assert {tuple(row) for row in np.column_stack([nozzle.x, nozzle.error, nozzle.line]).tolist()} <= there
        assert {tuple(row) for row in layer.desired.x.tolist()} <= path
        assert nozzle.error.max() == passage.contour[e.extruding & (e.layer == layer.number)].max()
        assert layer.z == pytest.approx(0.2 * (layer.number + 1))
        assert nozzle.new[0] and nozzle.new.sum() <= 1 + 1  # three sides in one go, a travel, three sides


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), CUTS)
def test_pieces_do_not_break_lines(seed, cuts):
    """Where the print goes on, the drawn line does, and it starts where the print does."""
    whole, parts = kept({"none": [square(4, 0.2, seed)]}), kept({"none": pieces(square(4, 0.2, seed), cuts)})
    for a, b in zip(whole.layers, parts.layers, strict=True):
        first, second = a.nozzle["none"], b.nozzle["none"]
        np.testing.assert_array_equal(first.x[first.new], second.x[second.new])


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), CUTS)
def test_curves_do_not_depend_on_the_pieces(seed, cuts):
    passage = square(4, 0.2, seed)
    whole, parts = (kept({"none": each}).methods["none"] for each in ([passage], pieces(passage, cuts)))
    for curve in ("error", "moves"):
        for name in ("low", "high", "rms"):
            first, second = (getattr(getattr(each, curve), name) for each in (whole, parts))
            np.testing.assert_allclose(second, first, atol=1e-6)
    e = passage.execution
    assert whole.error.high.max() == passage.contour[e.extruding].max()
    assert np.abs(whole.moves.high[:, :2]).max() == pytest.approx(SPEED)
    assert whole.seconds == e.time[-1]


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), CUTS)
def test_the_worst_corner_is_the_largest_error_and_corners_are_apart(seed, cuts):
    passage = square(4, 0.2, seed)
    e = passage.execution
    found = kept({"none": pieces(passage, cuts)}).corners
    worst = np.argmax(np.where(e.extruding, passage.contour, 0.0))
    assert found[0].error == passage.contour[worst] and found[0].line == e.line[worst]
    at = np.array([corner.at for corner in found])
    apart = np.hypot(*(at[:, None] - at).T) + 1e9 * np.eye(len(at))
    assert apart.min() >= APART_MM
    assert all(corner.layer == corner.line // 4 for corner in found)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), CUTS, st.booleans())
def test_another_method_is_seen_at_the_same_place(seed, cuts, by_turns):
    """On its own clock, in two runs over the file or in one."""
    before, after = square(4, 0.2, seed), square(4, 0.02, seed + 1)
    if by_turns:
        traces = Traces(100_000, 4)
        for a, b in zip(pieces(before, cuts), pieces(after, cuts), strict=True):
            traces.add("none", a)
            traces.add("lpfbs", b)
        found = traces.kept()
    else:
        found = kept({"none": pieces(before, cuts), "lpfbs": pieces(after, cuts)})
    for corner in found.corners:
        if corner.method == "none" or by_turns:
            own = corner.windows[corner.method]
            other = corner.windows["lpfbs" if corner.method == "none" else "none"]
            assert np.hypot(*(other.desired - np.array(corner.at)).T).min() < 1e-9
            assert (other.desired >= own.desired.min(axis=0) - 0.03).all()
            assert set(other.line.tolist()) <= set(own.line.tolist())
            assert corner.at in [tuple(row) for row in own.desired.tolist()]


def test_a_long_print_needs_no_more_room_than_a_short_one():
    """Four hours: the same layers over and over."""
    traces, budget, seconds, k = Traces(20_000, 3), 20_000, 4 * 3600, 0
    layer = square(10, 0.2)
    while k * 10 * LAYER * DT < seconds:
        for name in ("none", "lpfbs"):
            traces.add(name, _later(layer, 10 * k))
        k += 60  # a tenth of a minute of each minute is enough of a test
    found = traces.kept()
    count = sum(len(path) for each in found.layers for path in (each.desired, *each.nozzle.values()))
    assert 0.2 * budget < count <= budget
    assert found.thinning.stride > 1 and {each.number % found.thinning.stride for each in found.layers} == {0}
    assert all(set(each.nozzle) == {"none", "lpfbs"} for each in found.layers)
    assert found.methods["none"].seconds > 0.9 * seconds and len(found.corners) == 3 + 2


def _later(passage, layers: int):
    e = passage.execution
    later = replace(e, time=e.time + layers * LAYER * DT, layer=e.layer + layers, line=e.line + 4 * layers)
    return replace(passage, execution=later)


def test_where_nothing_is_extruded_every_move_draws_and_moves_before_the_first_line_do_not():
    passage = square(3, 0.2)
    dry = replace(passage, execution=replace(passage.execution, extruding=np.zeros(len(passage), dtype=bool)))
    assert len(kept({"none": [dry]}).layers) == 3
    found = kept({"none": [dry, _later(passage, 3)]})
    assert [layer.number for layer in found.layers] == [3, 4, 5]
    assert all(corner.layer >= 3 for corner in found.corners)


@settings(max_examples=30)
@given(st.lists(st.floats(0, 30), min_size=1, max_size=200), st.lists(st.integers(0, 199), max_size=4))
def test_segments_are_counted_by_the_second(starts, cuts):
    starts = np.sort(starts)
    traces = Traces()
    traces.add("none", square(1, 0.1))
    for part in np.split(starts, sorted(cut for cut in cuts if cut < len(starts))):
        traces.segments("none", part)
    found = traces.kept().methods["none"].segments
    counts = np.bincount(starts.astype(int))
    assert found.high.max() == counts.max()
    assert len(found.begin) == (counts > 0).sum()


def test_responses_are_those_of_a_known_plant():
    """A nozzle that is half as far as it should be, at every frequency."""
    passage = square(12, 0.0, travel=False)
    half = replace(passage, nozzle=100 + 0.5 * (passage.execution.desired - 100))
    found = kept({"none": [half]}).methods["none"]
    for frf, gain in ((found.asked[0], 1.0), (found.reached[0], 0.5), (found.reached[1], 0.5)):
        assert np.abs(frf.H - gain).max() < 1e-3  # of rounded positions' second differences
    assert kept({"none": [square(1, 0.1)]}).methods["none"].asked == (None, None)  # too short to tell
    assert SIDE == LAYER // 4
