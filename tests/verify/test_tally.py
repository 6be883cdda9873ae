"""Figures of a print collected in pieces are the figures of the print."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.motion.profile import Profile
from fbfcli.plant.model import plant_of
from fbfcli.printer import ModalModel, Mode
from fbfcli.verify.tally import Stretches, Tally

DT = 1e-3
STEP = 5  # samples in a segment
PLANT = plant_of(ModalModel((Mode(40.0, 0.1),)), DT, "x")
SOFT, RIGID = [(PLANT.b, PLANT.a)] * 2, [(np.ones(1), np.ones(1))] * 2


def at_constant_speed(begin: np.ndarray, end: np.ndarray, lasts: np.ndarray) -> Profile:
    speed, none = np.hypot(*(end - begin).T) / lasts, np.zeros(len(lasts))
    return Profile(speed, speed, speed, none + 1.0, none, lasts, none, lasts)


def stretch(seed: int, segments: int, late: float = 0.0) -> Stretches:
    """One stretch of straight segments whose command is what they do, executed `late` times too slowly."""
    rng = np.random.default_rng(seed)
    nodes = 10.0 + np.cumsum(rng.normal(0, 0.3, (segments + 1, 2)) + 0.01, axis=0)
    n = segments * STEP + 1
    k = np.arange(n) / STEP
    command = np.column_stack([np.interp(k, np.arange(segments + 1), nodes[:, i]) for i in (0, 1)])
    wanted = np.full(segments, STEP * DT)
    return piece(nodes, command, rng.random(n) < 0.7, wanted, wanted * (1.0 + late), 0, segments, segments)


def piece(nodes, command, extruding, wanted, lasts, a: int, b: int, of: int) -> Stretches:
    """Segments a to b of a stretch of `of` segments."""
    start, delta = np.zeros((b - a, 4)), np.zeros((b - a, 4))
    start[:, :2], delta[:, :2] = nodes[a:b], np.diff(nodes[a : b + 1], axis=0)
    rows = slice(a * STEP, b * STEP + 1)
    executed = at_constant_speed(nodes[a:b], nodes[a + 1 : b + 1], lasts[a:b])
    return Stretches(
        begin=np.array([0]), end=np.array([(b - a) * STEP]), rest=np.array([0]), begun=a > 0, goes_on=b < of,
        desired=command[rows], command=command[rows], extruding=extruding[rows],
        line=np.arange(len(command))[rows] // STEP, first=np.array([0]), start=start,
        delta=delta, distance=np.hypot(*delta[:, :2].T), wanted=wanted[a:b],
        late=float((lasts - wanted)[:a].sum()), executed=executed, dt=DT,
    )  # fmt: skip


def figures(tally: Tally) -> dict[str, dict[str, float]]:
    return {name: getattr(tally, name).figures() for name in ("follow", "chord", "before", "after")}


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_segments_that_do_the_command_follow_it_and_a_rigid_nozzle_has_no_error(seed, segments):
    tally = Tally(RIGID)
    tally.add(stretch(seed, segments))
    assert all(one["max"] < 1e-6 for one in figures(tally).values())
    assert tally.segments == segments and tally.drift_ppm == pytest.approx(0.0, abs=1e-6)
    assert tally.rate == pytest.approx(1 / (STEP * DT))


@given(st.integers(0, 2**32 - 1), st.integers(2, 60), st.floats(1e-3, 0.5))
def test_what_the_segments_leave_of_the_command_is_chord_error_not_follow_error(seed, segments, off):
    """A command that swings between the nodes is followed by none of it: the segments are executed as they are."""
    part = stretch(seed, segments)
    swing = off * np.sin(np.pi * np.arange(len(part.command)) / STEP)
    tally = Tally(RIGID)
    tally.add(Stretches(**{**part.__dict__, "command": part.command + np.column_stack([swing, 0 * swing])}))
    assert tally.follow.figures()["max"] < 1e-6
    assert tally.chord.figures()["max"] == pytest.approx(1e3 * np.abs(swing).max(), rel=1e-6)


@given(st.integers(0, 2**32 - 1), st.integers(2, 60), st.floats(1e-6, 1e-3))
def test_what_is_executed_late_is_follow_error_not_chord_error(seed, segments, late):
    part = stretch(seed, segments, late)
    tally = Tally(RIGID)
    tally.add(part)
    speed = np.hypot(*np.diff(part.polyline(), axis=0).T).max() / DT
    assert tally.chord.figures()["max"] < 1e-6
    assert 0.0 < tally.follow.figures()["max"] <= 1e3 * speed * late * segments * STEP * DT + 1e-6


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.floats(-1e-3, 1e-3))
def test_drift_is_the_relative_lateness(seed, segments, late):
    tally = Tally(RIGID)
    tally.add(stretch(seed, segments, late))
    assert tally.drift_ppm == pytest.approx(1e6 * late, abs=1e-6)


@given(st.integers(0, 2**32 - 1), st.integers(2, 60))
def test_uncompensated_segments_shake_as_the_desired_motion_does(seed, segments):
    tally = Tally(SOFT)
    tally.add(stretch(seed, segments))
    before, after = tally.before.figures(), tally.after.figures()
    assert after["rms"] == pytest.approx(before["rms"], rel=1e-6, abs=1e-6)


@settings(max_examples=60)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 120),
    st.lists(st.integers(1, 119), max_size=5),
    st.sampled_from((0.0, 1e-3)),
)
def test_a_stretch_in_pieces_has_the_figures_of_the_stretch(seed, segments, cuts, late):
    """Contour errors are taken at every fourth extruding sample of a piece, so they agree within a few per cent."""
    whole = stretch(seed, segments, late)
    nodes = np.vstack([whole.start[:, :2], whole.start[-1:, :2] + whole.delta[-1:, :2]])
    one, many = Tally(SOFT), Tally(SOFT)
    one.add(whole)
    ends = sorted({cut for cut in cuts if cut < segments} | {0, segments})
    for a, b in pairwise(ends):
        many.add(piece(nodes, whole.command, whole.extruding, whole.wanted, whole.executed.duration, a, b, segments))
    for kind in ("follow", "chord"):
        for name in ("rms", "max"):
            assert figures(many)[kind][name] == pytest.approx(figures(one)[kind][name], rel=1e-6, abs=1e-6)
    assert many.drift_ppm == pytest.approx(one.drift_ppm, abs=1e-6) and many.segments == one.segments
    if segments > 60:
        for name in ("before", "after"):
            assert figures(many)[name]["rms"] == pytest.approx(figures(one)[name]["rms"], rel=0.25, abs=1.0)


def test_stretches_after_a_rest_are_told_apart():
    """Two stretches in one batch or in two: the nozzle comes to rest between them alike."""
    first = stretch(1, 20)
    together, apart = Tally(SOFT), Tally(SOFT)
    n = len(first.desired)
    begin, end = (np.vstack([x[:, :2]] * 2) for x in (first.start, first.start + first.delta))
    both = Stretches(
        begin=np.array([0, n]), end=np.array([n - 1, 2 * n - 1]), rest=np.array([0, 30]), begun=False, goes_on=False,
        desired=np.vstack([first.desired] * 2), command=np.vstack([first.command] * 2),
        extruding=np.tile(first.extruding, 2), line=np.tile(first.line, 2), first=np.array([0, 20]),
        start=np.vstack([first.start] * 2),
        delta=np.vstack([first.delta] * 2), distance=np.tile(first.distance, 2), wanted=np.tile(first.wanted, 2),
        executed=at_constant_speed(begin, end, np.tile(first.wanted, 2)), late=0.0, dt=DT,
    )  # fmt: skip
    together.add(both)
    apart.add(first)
    apart.add(Stretches(**{**first.__dict__, "rest": np.array([30])}))
    assert together.segments == apart.segments == 40
    for name in ("follow", "chord", "before", "after"):
        a, b = figures(together)[name], figures(apart)[name]
        assert b["rms"] == pytest.approx(a["rms"], rel=0.1, abs=1e-6)
