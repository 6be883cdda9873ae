"""Laws of fed-back time: the planner of each firmware spends what each segment should last."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_moves import moves_of, paths

from fbfcli.motion.moves import Moves
from fbfcli.motion.timing import executed, made_good, timed
from fbfcli.printer import FIRMWARES, Limits

each_firmware = pytest.mark.parametrize("firmware", FIRMWARES)
RAISED = Limits(
    velocity=5000.0, acceleration=1e6, travel_acceleration=1e6, axis_velocity=(2000.0, 2000.0, 20.0, 80.0),
    axis_acceleration=(1e6, 1e6, 500.0, 5000.0), jerk=(1000.0, 1000.0, 0.4, 2.5), square_corner_velocity=1e5,
    minimum_cruise_ratio=0.0,
)  # fmt: skip


def exact(v: np.ndarray) -> np.ndarray:
    return v


def to_words(v: np.ndarray) -> np.ndarray:
    """As an F with two decimals."""
    return np.maximum(np.rint(v * 6000.0), 1.0) / 6000.0


def command(seed: int, n: int) -> tuple[Moves, np.ndarray]:
    """Segments of a command from rest to rest, a hundredth of the raised acceleration, and their times."""
    rng = np.random.default_rng(seed)
    wanted = rng.integers(3, 30, n) * 1e-3
    bend = np.concatenate([[0.0], rng.normal(0, 1.0, n - 1)])
    t = np.cumsum(wanted)
    speed = np.maximum(120.0 * np.sin(np.pi * (t - 0.5 * wanted) / t[-1]), 2.0)
    angle = np.cumsum(0.2 * bend * wanted * 1e3 / np.maximum(speed, 20.0))
    d = speed * wanted
    delta = np.column_stack([d * np.cos(angle), d * np.sin(angle), np.zeros(n), np.zeros(n)])
    return moves_of(delta, 100.0, RAISED), wanted


commands = st.tuples(st.integers(0, 2**32 - 1), st.integers(2, 60))


@each_firmware
@given(commands, st.sampled_from((exact, to_words)))
def test_the_firmware_takes_the_wanted_time(firmware, case, quantise):
    """Over the stretch 20 us, or 20 ppm of a long one."""
    moves, wanted = command(*case)
    asked, done = timed(moves, wanted, 0.0, firmware, quantise)
    assert abs(done.duration.sum() - wanted.sum()) < 2e-5 + 2e-5 * wanted.sum()
    again = executed(asked, firmware)
    np.testing.assert_array_equal(again.duration, done.duration)
    np.testing.assert_array_equal(asked.speed, quantise(asked.speed))


@each_firmware
@given(commands)
def test_no_segment_is_ever_much_too_late_or_early(firmware, case):
    moves, wanted = command(*case)
    _, done = timed(moves, wanted, 0.0, firmware, exact)
    assert np.abs(np.cumsum(done.duration - wanted)).max() < 1e-3


@each_firmware
@given(commands, st.floats(0.0, 2e-3))
def test_lateness_is_made_good(firmware, case, late):
    moves, wanted = command(*case)
    _, done = timed(moves, wanted, late, firmware, exact)
    left = late + done.duration.sum() - wanted.sum()
    assert left <= max(late - 0.04 * wanted.sum(), 0.0) + 3e-5 + 2e-5 * wanted.sum()
    assert left > -5e-5


@pytest.mark.parametrize("firmware", ("marlin", "reprapfirmware"))
@given(st.floats(8.0, 11.0), st.floats(1.0, 4.0), st.integers(34, 60))
def test_what_the_extruder_held_up_is_made_good_by_the_slow_segment_before_the_stop(firmware, pulled, speed, lasts):
    """A wipe: E is pulled through chords that must change their speed, then crawls to the stop."""
    limits = replace(RAISED, axis_velocity=(2000.0, 2000.0, 20.0, 25.0), axis_acceleration=(1e6, 1e6, 500.0, 9000.0),
                     jerk=(1000.0, 1000.0, 0.4, 10.0))  # fmt: skip
    wanted = np.array([12, 7, 3, 4, lasts]) * 1e-3
    d = np.array([36.0, 22.0, 13.0, 60.0, speed]) * wanted
    e = -np.array([pulled, pulled, pulled, pulled, 3.0]) * wanted
    moves = moves_of(np.column_stack([d, 0 * d, 0 * d, e]), 100.0, limits)
    _, done = timed(moves, wanted, 0.0, firmware, to_words)
    late = np.cumsum(done.duration - wanted)
    assert late[:-1].max() > 5e-5, "it is held up"
    assert abs(late[-1]) < 3e-5


rows = st.lists(st.tuples(st.floats(-1e-3, 1e-3), st.floats(0, 1e-3), st.booleans()), min_size=1, max_size=40)


@given(rows, st.floats(0, 2e-3))
def test_made_good_time_is_a_queue_one_segment_at_a_time(rows, late):
    delay, capacity, start = (np.array(column) for column in zip(*rows, strict=True))
    left, expected = late, []
    for one, most, anew in rows:
        left = 0.0 if anew else left
        after = max(left + one - most, 0.0)
        expected.append(left + one - after)
        left = after
    np.testing.assert_allclose(made_good(delay, capacity, np.flatnonzero(start), late), expected, atol=1e-12)


@each_firmware
@given(paths(max_size=12, states=1))
def test_moves_from_rest_to_rest_are_planned_so(firmware, moves):
    done = executed(moves, firmware)
    least = 0.06 if firmware == "marlin" else 0.0  # its minimum planner speed
    assert done.v_start[0] <= least and done.v_end[-1] <= least


@each_firmware
@given(paths(max_size=12, states=1))
def test_moves_entered_and_left_in_motion_are_never_faster_than_asked(firmware, moves):
    done = executed(moves, firmware, goes_in=True, goes_on=True)
    least = 0.5 if firmware == "reprapfirmware" else 0.06  # minimum speeds
    assert (done.v_cruise <= np.maximum(moves.speed, least) * (1 + 1e-9)).all()
    assert done.duration.sum() <= executed(moves, firmware).duration.sum() * (1 + 1e-9)


@each_firmware
@settings(max_examples=50)
@given(commands, st.data())
def test_a_stretch_timed_in_two_parts_keeps_the_clock(firmware, case, data):
    moves, wanted = command(*case)
    cut = data.draw(st.integers(1, len(wanted) - 1))
    _, first = timed(moves[:cut], wanted[:cut], 0.0, firmware, exact, False, True)
    late = float(first.duration.sum() - wanted[:cut].sum())
    _, second = timed(moves[cut:], wanted[cut:], late, firmware, exact, True, False)
    total = first.duration.sum() + second.duration.sum()
    assert abs(total - wanted.sum()) < 5e-4
