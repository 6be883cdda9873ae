"""Steps stand for the positions they come from, everywhere."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from step_cases import DT, NO_JUMP, NS, TRAVEL, motions, standing

from fbfcli.steps.curve import position
from fbfcli.steps.pulses import Motor
from fbfcli.steps.stream import MotorSteps, joined

RATE = 80.0  # steps/mm
ROUNDING = 2e-5  # steps: what a motor at 300 mm/s moves in half a nanosecond, and floating point
bands = pytest.mark.parametrize("band", [0.0, 0.02, 0.3])


def stepped(x: np.ndarray, band: float, cuts: tuple[int, ...] = ()) -> MotorSteps:
    """Steps of positions at 1 ms, given to the motor in pieces."""
    motor, tick = Motor(RATE, band, DT), np.arange(len(x))
    edges = [0, *sorted(cuts), len(x)]
    parts = [
        motor.push(tick[a:b], x[a:b], NO_JUMP, b == len(x) and i == len(edges) - 2)
        for i, (a, b) in enumerate(pairwise(edges))
    ]
    return joined(parts)


def start(x: np.ndarray) -> int:
    return int(np.rint(x[0] * RATE))


@bands
@given(x=motions(), data=st.data())
def test_steps_are_within_half_a_step_of_the_position_everywhere(band, x, data):
    steps = stepped(x, band)
    rng = np.random.default_rng(data.draw(st.integers(0, 999)))
    end = (len(x) - 1) * NS
    at = np.concatenate([rng.integers(0, end, 500), np.arange(len(x)) * NS, steps.time, steps.time - 1])
    at = at[(at >= 0) & (at <= end)]
    error = standing(steps, start(x), at) - position(x * RATE, at / NS)
    assert np.abs(error).max() <= 0.5 + band / 2 + ROUNDING


@bands
@given(x=motions())
def test_they_end_on_the_nearest_step(band, x):
    assert start(x) + stepped(x, band).moved == np.rint(x[-1] * RATE)


@given(x=motions(), data=st.data())
def test_pieces_make_the_same_steps(x, data):
    cuts = data.draw(st.lists(st.integers(0, len(x)), max_size=8))
    one, many = stepped(x, 0.02), stepped(x, 0.02, tuple(cuts))
    assert (one.time == many.time).all()
    assert (one.forward == many.forward).all()


@given(x=motions())
def test_times_increase(x):
    assert (np.diff(stepped(x, 0.02).time) > 0).all()


@given(noise=st.floats(1e-9, 0.0098), seed=st.integers(0, 999), middle=st.integers(0, 50))
def test_noise_within_the_band_takes_no_step_back(noise, seed, middle):
    """A position that trembles on a half step, by less than the band."""
    rng = np.random.default_rng(seed)
    x = (middle + 0.5 + noise * rng.uniform(-1, 1, 500)) / RATE
    x[0] = middle / RATE
    steps = stepped(x, 0.02)
    assert steps.forward[:-1].all()
    assert len(steps) <= 2  # one, and at the end the nearest


def test_without_a_band_it_does_chatter():
    tremble = 50.5 + 0.001 * (-1.0) ** np.arange(100)
    assert len(stepped(tremble / RATE, 0.0)) > 50
    assert len(stepped(tremble / RATE, 0.02)) <= 1


def test_a_constant_speed_makes_equal_gaps():
    x = 40.0 * DT * np.arange(1000)  # 3200 steps/s
    gap = np.diff(stepped(x, 0.02).time)[5:-5]  # it starts, and stops, within the first period, and the last
    assert np.abs(gap - 1e9 / 3200).max() <= 1


def test_steps_of_a_parabola_come_at_their_times():
    k = np.arange(200.0)
    x = 0.5 * 2000.0 * (k * DT) ** 2  # 2000 mm/s^2 from rest
    steps = stepped(np.append(x, x[-1:]), 0.0)
    level = np.arange(len(steps) - 1) + 0.5
    expected = np.sqrt(2.0 * level / RATE / 2000.0)
    moving = expected < 198 * DT  # the last period turns to rest
    assert np.abs(steps.time[:-1][moving] - 1e9 * expected[moving]).max() < 1.0


@given(x=motions(), home=st.floats(-50.0, 50.0))
def test_a_set_position_is_no_motion_but_counts(x, home):
    """Homing: the motor is told where it is, takes up to half a step, and ends where the positions end."""
    there = x - x[0] + home
    motor, tick = Motor(RATE, 0.02, DT), np.arange(2 * len(x))
    steps = motor.push(tick, np.concatenate([x, there]), np.array([len(x)]), True)
    alone = stepped(x, 0.02), stepped(there, 0.02)
    assert motor.taken == np.rint(there[-1] * RATE)
    assert abs(len(steps) - len(alone[0]) - len(alone[1])) <= 4
    assert start(x) + steps.moved + motor.set == motor.taken


def test_a_rest_is_a_gap_in_the_ticks():
    x = np.concatenate([np.linspace(TRAVEL, TRAVEL + 1, 30), np.linspace(TRAVEL + 1, TRAVEL, 30)])
    late = np.where(np.arange(60) < 30, 0, 10_000)
    waiting = Motor(RATE, 0.02, DT).push(np.arange(60) + late, x, NO_JUMP, True)
    passing = stepped(x, 0.02)
    assert (waiting.forward == passing.forward).all()
    shift = waiting.time - passing.time
    assert set(np.unique(shift)) <= {0, 10_000 * NS}


def test_nothing_makes_no_steps():
    nothing = np.zeros(0)
    assert not len(Motor(RATE, 0.02, DT).push(NO_JUMP, nothing, NO_JUMP, True))
