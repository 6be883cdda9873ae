"""Planners with the queue they really have: an oracle that goes from event to event, and cases by hand."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_moves import moves_of, paths
from scalar_queue import marlin_times, steps_kept

from fbfcli.cli.lookup import bundled
from fbfcli.motion.planner import Part, Planner, divided
from fbfcli.pipeline import Settings
from fbfcli.pipeline.reader import Reader
from fbfcli.printer import Limits, Printer
from fbfcli.verify.block_queue import BlockQueue, Queue
from fbfcli.verify.firmware import QueuePlanner, planner_of
from fbfcli.verify.merged_moves import Merging

MARLIN = Queue(16, 1 / 300, end_w=0.05**2, segment_s=0.02, first_waits_s=0.1, first_waits_for=2)


def fed(planner, moves, sizes=(10**6,)) -> list[Part]:
    parts, at, turn = [], 0, 0
    while at < len(moves):
        end = min(at + sizes[turn % len(sizes)], len(moves))
        parts += list(planner.feed(moves[at:end], np.arange(at, end), end == len(moves)))
        at, turn = end, turn + 1
    return parts


def durations(parts: list[Part]) -> np.ndarray:
    return np.concatenate([part.profile.duration for part in parts])


@settings(max_examples=80)
@given(
    paths(max_size=60, junction_deviation=np.nan) | paths(max_size=60, junction_deviation=0.02),
    st.sampled_from((4, 8, 16)),
    st.sampled_from((1e-4, 1 / 300, 0.021, 0.13)),
    st.sampled_from((0.0, 0.02)),
)
def test_marlin_agrees_with_the_queue_event_by_event(moves, blocks, period, segment_s):
    queue = replace(MARLIN, blocks=blocks, period=period, segment_s=segment_s)
    found, _ = BlockQueue("marlin", queue).executed(moves, last=True)
    _, wanted = marlin_times(moves, blocks, period, segment_s)
    np.testing.assert_allclose(found.duration, wanted, rtol=1e-9, atol=1e-9)


@settings(max_examples=40)
@given(paths(max_size=80), st.lists(st.integers(1, 30), min_size=1, max_size=4), st.sampled_from((1 / 300, 0.02)))
def test_parts_are_all_moves_in_order_with_the_plan_of_the_whole(moves, sizes, period):
    moves, _ = divided(moves, np.arange(len(moves)))
    one, many = (
        fed(QueuePlanner("marlin", replace(MARLIN, blocks=8, period=period), None), moves, s) for s in ((10**6,), sizes)
    )
    np.testing.assert_array_equal(np.concatenate([part.tag for part in many]), np.arange(len(moves)))
    np.testing.assert_allclose(durations(many), durations(one), rtol=1e-9, atol=1e-9)


@settings(max_examples=60)
@given(paths(max_size=60))
def test_a_queue_that_is_long_enough_is_no_limit(moves):
    """RepRapFirmware with a ring for everything, moves that come at once, settled as late as can be: `Planner`."""
    moves, _ = divided(moves, np.arange(len(moves)))
    queue = Queue(200, 1e-9, first_waits_s=1e-3)
    found = fed(QueuePlanner("reprapfirmware", queue, None), moves)
    wanted = fed(Planner("reprapfirmware"), moves)
    np.testing.assert_allclose(durations(found), durations(wanted), rtol=1e-6, atol=1e-9)


@settings(max_examples=40)
@given(paths(max_size=60), st.integers(4, 40), st.sampled_from((0.0, 0.1)))
def test_a_shorter_queue_is_never_faster(moves, blocks, ahead_s):
    moves = replace(moves, stop=np.zeros(len(moves), bool))
    total = [
        durations(fed(QueuePlanner("reprapfirmware", Queue(many, 1e-9, ahead_s=ahead_s), None), moves)).sum()
        for many in (blocks, 2 * blocks)
    ]
    assert total[0] >= total[1] * (1 - 1e-9)


def test_sixteen_blocks_are_too_few_for_short_segments():
    """By hand: with d = 0.1 mm and a = 1000 the 13 blocks after the one that begins are 1.3 mm to stop in: 51 mm/s."""
    moves = moves_of([[0.1, 0, 0, 0]] * 400, 200.0, Limits(acceleration=1000.0, travel_acceleration=1000.0,
                                                           junction_deviation=0.02))  # fmt: skip
    queue = replace(MARLIN, period=1e-5, segment_s=0.0)
    timing, _ = BlockQueue("marlin", queue).executed(moves, last=True)
    assert timing.v_end[200] == pytest.approx(np.sqrt(0.05**2 + 2 * 1000.0 * 1.3), rel=1e-9)
    whole = fed(Planner("marlin"), moves)
    assert max(part.profile.v_cruise.max() for part in whole) > 190.0


def test_lines_that_come_slowly_stop_the_machine_at_every_block():
    moves = moves_of([[1.0, 0, 0, 0]] * 10, 100.0, Limits(acceleration=1e4, travel_acceleration=1e4,
                                                          junction_deviation=0.02))  # fmt: skip
    timing, _ = BlockQueue("marlin", replace(MARLIN, period=0.5)).executed(moves, last=True)
    np.testing.assert_allclose(timing.v_end, 0.05)
    np.testing.assert_allclose(timing.v_start, 0.05)


def test_short_segments_are_stretched_while_the_queue_fills():
    """1 ms segments, one line every 3.3 ms: the third comes when two wait and takes 1 + 2 * 19 / 2 ms = 20 ms."""
    moves = moves_of([[0.1, 0, 0, 0]] * 3, 100.0, Limits(acceleration=1e6, travel_acceleration=1e6,
                                                         junction_deviation=0.02))  # fmt: skip
    _, asked = BlockQueue("marlin", MARLIN).executed(moves, last=True)
    np.testing.assert_allclose(asked, [100.0, 100.0, 0.1 / 0.02])


def test_marlin_starts_at_its_safe_speed_and_ends_at_the_slowest():
    limits = Limits(travel_acceleration=1000.0, jerk=(8.0, 8.0, 0.4, 5.0))
    timing, _ = BlockQueue("marlin", MARLIN).executed(moves_of([[50.0, 0, 0, 0]], 100.0, limits), last=True)
    assert (timing.v_start[0], timing.v_end[0]) == pytest.approx((8.0, 0.05))


@given(paths(max_size=80), st.lists(st.integers(1, 30), min_size=1, max_size=3), st.sampled_from((20.0, 80.0)))
def test_moves_of_a_few_steps_merge_into_the_next(moves, sizes, rate):
    rates = np.array([rate, rate, 400.0, 100.0])
    merging, found, at, turn = Merging(None, (rate, rate, 400.0), 100.0), [], 0, 0
    while at < len(moves):
        end = min(at + sizes[turn % len(sizes)], len(moves))
        found.append(merging.merged(moves[at:end], np.arange(at, end)))
        at, turn = end, turn + 1
    ends = moves.start + moves.delta
    kept = np.flatnonzero(steps_kept(ends, moves.start[0], rates))
    tags = np.concatenate([tag for _, tag in found])
    np.testing.assert_array_equal(tags, kept)
    start, delta = (np.concatenate([getattr(each, name) for each, _ in found]) for name in ("start", "delta"))
    np.testing.assert_allclose(start + delta, ends[kept], atol=1e-9)
    if len(kept):
        np.testing.assert_allclose(start[1:], ends[kept[:-1]], atol=1e-9)
        np.testing.assert_allclose(start[0], moves.start[0], atol=1e-9)
    stops = np.concatenate([each.stop for each, _ in found])
    before = [moves.stop[a + 1 : b + 1].any() for a, b in pairwise(np.append(-1, kept))]
    np.testing.assert_array_equal(stops, before)


def test_klipper_takes_a_square_corner_as_by_hand():
    """50 mm along X, 50 mm along Y at 100 mm/s, a = 3000, corner 5 mm/s: ramps of 100 / a and 95 / a."""
    printer = replace(marlin(), firmware="klipper")
    limits = Limits(velocity=300.0, acceleration=3000.0, square_corner_velocity=5.0, minimum_cruise_ratio=0.0)
    timing = fed(planner_of(printer), moves_of([[50.0, 0, 0, 0], [0, 50.0, 0, 0]], 100.0, limits))[0].profile
    ramps = 100.0**2 / 6000.0 + (100.0**2 - 5.0**2) / 6000.0
    wanted = 100.0 / 3000.0 + 95.0 / 3000.0 + (50.0 - ramps) / 100.0
    np.testing.assert_allclose(timing.duration, wanted, rtol=0, atol=1e-12)
    np.testing.assert_allclose([timing.v_end[0], timing.v_start[1]], 5.0)


STOPS = ("G4 P1", "M400", "G28", "SET_INPUT_SHAPER SHAPER_FREQ_X=0", "T1")
PASSES = (
    "M204 S900",
    "SET_VELOCITY_LIMIT ACCEL=900",
    "M106 S90",
    "M117 Hello",
    "G92 E0",
    "SET_PRESSURE_ADVANCE ADVANCE=0",
)


@pytest.mark.parametrize("line, stops", [*((line, True) for line in STOPS), *((line, False) for line in PASSES)])
def test_klipper_stops_where_its_rules_say(line, stops):
    """Straight on along X with a command between: at full speed, or from a halt to a halt."""
    printer = bundled()["synthetic_corexy"]
    text = f"G28\nG1 X10 Y10 F6000\nG1 X50 E1\n{line}\nG1 X60 Y10 E2\nG1 X99 E3\n".encode()
    reader = Reader(printer, Settings(), as_written=True, planner=planner_of(printer))
    parts = [portion.part for portion in reader.portions([text], lambda done: None)]
    after = np.concatenate([part.profile.v_start for part in parts])
    at = np.concatenate([part.moves.line for part in parts])
    assert (after[at == 4][0] == 0.0) == stops


def marlin() -> Printer:
    return bundled()["taz6"]


def test_each_firmware_has_its_planner():
    printer = marlin()
    assert isinstance(planner_of(replace(printer, firmware="klipper")), Planner)
    for firmware in ("marlin", "reprapfirmware"):
        parts = fed(planner_of(replace(printer, firmware=firmware)), moves_of([[5.0, 0, 0, 0.2]] * 30))
        assert sum(len(part.moves) for part in parts) == 30 and (durations(parts) > 0).all()


def test_after_homing_a_move_starts_where_the_machine_was_set():
    """A move of 2 steps is not queued; the one after it, from another place, has nothing to do with it."""
    moves = moves_of([[10.0, 0, 0, 0], [0.025, 0, 0, 0], [5.0, 0, 0, 0]])
    moves.start[2] = [200.0, 100.0, 0.0, 0.0]
    found, tag = Merging(None, (80.0, 80.0, 400.0), None).merged(moves, np.arange(3))
    assert tag.tolist() == [0, 2]
    np.testing.assert_allclose(found.start[1], [200.0, 100.0, 0.0, 0.0])
    np.testing.assert_allclose(found.delta[1], [5.0, 0.0, 0.0, 0.0])
