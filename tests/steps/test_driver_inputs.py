"""What a driver's inputs take, and what they do not."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.printer import Driver
from fbfcli.steps.driver_inputs import Inputs, TooFast
from fbfcli.steps.stream import MotorSteps

DRIVER = Driver(step_pulse=2e-6, direction_setup=1e-6, max_step_rate=100e3)  # 10 us between steps, 3 us at a turn


def taken(*steps: tuple[int, int]) -> MotorSteps | TooFast:
    time, way = zip(*steps, strict=True)
    return Inputs(DRIVER).taking(MotorSteps(np.array(time), np.array(way) > 0))


def test_a_rate_above_the_drivers_is_told_with_its_time():
    told = taken((0, 1), (10_000, 1), (19_000, 1), (50_000, 1))
    assert told == TooFast(19_000, 1e9 / 9_000)


def test_the_drivers_own_rate_is_taken_rounding_included():
    assert isinstance(taken((0, 1), (10_000, 1), (19_999, 1)), MotorSteps)


def test_a_turn_that_comes_too_soon_waits_for_the_direction():
    told = taken((0, 1), (1_000, -1), (13_000, -1))
    assert isinstance(told, MotorSteps)
    assert told.time.tolist() == [0, 3_000, 13_000]


def test_waiting_does_not_hide_a_rate_that_is_too_high():
    assert taken((0, 1), (1_000, -1), (11_500, -1)) == TooFast(11_500, 1e9 / 8_500)


@given(
    gaps=st.lists(st.integers(10_000, 10**7), min_size=1, max_size=50),
    ways=st.lists(st.booleans(), min_size=50, max_size=50),
    soon=st.integers(1, 10_000),
    cut=st.integers(0, 50),
)
def test_direction_never_changes_within_the_set_up_time(gaps, ways, soon, cut):
    """Also where a turn falls between two pieces."""
    forward = np.array(ways[: len(gaps)])
    turned = np.diff(forward, prepend=forward[:1])
    time = np.cumsum(np.where(turned, soon, np.array(gaps) + 150_000))  # turns in a row wait for each other
    inputs = Inputs(DRIVER)
    parts = [inputs.taking(MotorSteps(time[rows], forward[rows])) for rows in (slice(0, cut), slice(cut, None))]
    assert not any(isinstance(part, TooFast) for part in parts)
    told = np.concatenate([part.time for part in parts])
    assert (np.diff(told)[turned[1:]] >= 3_000).all()
    assert (told >= time).all()
    assert (told - time <= 3_000 * turned.sum()).all()


def test_the_peak_is_of_steps_in_one_direction_across_pieces():
    inputs = Inputs(DRIVER)
    for time, way in (([0, 40_000], [True, True]), ([60_000, 64_000], [True, False])):
        inputs.taking(MotorSteps(np.array(time), np.array(way)))
    assert inputs.peak_rate == 1e9 / 20_000


def test_no_steps_no_peak():
    inputs = Inputs(DRIVER)
    inputs.taking(MotorSteps(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)))
    assert inputs.peak_rate == 0.0
