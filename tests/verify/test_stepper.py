"""Steppers under a print: what they are asked for, where steps are lost, and that the choice of windows misses none."""

from dataclasses import replace
from itertools import pairwise
from math import asin, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motor_cases import DT, LOAD, MIDDLE, MOTOR, along, execution, printer, rigid, there, told

from fbfcli.errors import LimitError
from fbfcli.printer import Load
from fbfcli.verify.rotor import Course, rotor_of
from fbfcli.verify.rotor_windows import Windows
from fbfcli.verify.stepper import Motors
from fbfcli.verify.torque_speed import standstill_torque

ARM = MOTOR.mm_per_turn / (2e3 * pi)  # m
TORQUE = standstill_torque(MOTOR)
HEAVY = Load(2.0)
LIGHT_ROTOR = replace(MOTOR, rotor_inertia=1e-8)
BREAKAWAY = 1e3 * TORQUE / (ARM * HEAVY.mass)  # mm/s^2 that takes all of the torque


def moves(*accelerations: float, speed: float = 150.0) -> np.ndarray:
    """X Y Z of moves of 40 mm in X, there and back by turns, one for each acceleration, with rests between."""
    ways = [there(40.0, speed, a) for a in accelerations]
    return along(0, np.concatenate([2.0 * MIDDLE + 40.0 - x if i % 2 else x for i, x in enumerate(ways)]))


@pytest.mark.parametrize(("friction", "speed"), [(0.0, 150.0), (4.0, 50.0), (15.0, 99.0)])
def test_at_constant_speed_friction_alone_makes_a_load_angle(friction, speed):
    """asin(T / T_max) where nothing is accelerated, and none without friction; the ramps take 0.02."""
    machine, shares = printer(motor=replace(MOTOR, damping=0.7), load=Load(1e-9, friction)), []
    motors = Motors(machine, DT, 0.0, lambda time, share, names: shares.append(share))
    motors.add(rigid(execution(along(0, there(0.2 * speed, speed, speed / 0.1, rest=5)))))
    motor = motors.figures().motors[0]
    assert shares[0][150] == pytest.approx(friction * ARM / TORQUE, abs=1e-6)
    assert motor.angle == pytest.approx(asin(friction * ARM / TORQUE) * 2 / pi, abs=0.02)
    assert motor.angle_um == pytest.approx(motor.angle * 200.0)


@given(st.floats(0.1, 3.0), st.floats(500.0, 8000.0))
@settings(max_examples=15)
def test_a_mass_asks_for_its_acceleration(mass, acceleration):
    motor = told(moves(acceleration), printer(motor=replace(MOTOR, damping=0.9), load=Load(mass))).motors[0]
    carried = mass + MOTOR.rotor_inertia / ARM**2
    assert motor.share == pytest.approx(1e-3 * carried * acceleration * ARM / TORQUE, rel=0.01)
    assert motor.headroom == 1.0 - motor.share


def test_a_move_beyond_the_torque_loses_steps_where_it_is_and_one_below_it_none():
    x = moves(0.3 * BREAKAWAY, 0.6 * BREAKAWAY, 1.3 * BREAKAWAY)
    second = len(moves(0.3 * BREAKAWAY))
    third = len(moves(0.3 * BREAKAWAY, 0.6 * BREAKAWAY))
    lines = np.repeat([10, 20, 30], [second, third - second, len(x) - third])
    motors = Motors(printer(load=HEAVY), DT)
    motors.add(rigid(execution(x, lines)))
    figures = motors.figures()
    assert figures.lost and {one.motor for one in figures.lost} == {"x"}
    assert all(one.line == 31 and one.steps > 0 and one.steps % 4 == 0 for one in figures.lost)
    assert third * DT < figures.lost[0].time < len(x) * DT
    assert figures.motors[0].angle == 2.0 and figures.motors[0].share_at.line == 31
    below = told(moves(0.3 * BREAKAWAY, 0.6 * BREAKAWAY), printer(load=HEAVY))
    assert not below.lost and below.motors[0].integrated > 0.0
    assert 0.5 < below.motors[0].angle < 1.5


@given(st.lists(st.floats(0.1, 1.6), min_size=1, max_size=2), st.floats(100.0, 400.0))
@settings(max_examples=4)
def test_windows_lose_the_steps_that_the_whole_print_loses(shares, speed):
    x = moves(*(share * BREAKAWAY for share in shares), speed=speed)
    picked, whole = (told(x, printer(load=HEAVY), needed) for needed in (0.5, 0.0))
    assert whole.motors[0].integrated == 1.0 > picked.motors[0].integrated
    assert [one.line for one in picked.lost] == pytest.approx([one.line for one in whole.lost], abs=2)
    assert [one.steps for one in picked.lost] == [one.steps for one in whole.lost]
    if picked.motors[0].windows:
        assert picked.motors[0].angle == pytest.approx(whole.motors[0].angle, rel=0.02)
    else:
        assert picked.motors[0].angle >= 0.99 * whole.motors[0].angle


@given(st.integers(2, 40))
@settings(max_examples=6)
def test_how_a_print_is_cut_makes_no_difference(pieces):
    x = moves(0.2 * BREAKAWAY, 0.6 * BREAKAWAY, 1.2 * BREAKAWAY)
    whole, cut = told(x, printer(load=HEAVY)), told(x, printer(load=HEAVY), pieces=pieces)
    assert cut.lost == whole.lost
    for a, b in zip(cut.motors, whole.motors, strict=True):
        assert a.share == pytest.approx(b.share) and a.angle == pytest.approx(b.angle)
        assert (a.share_at.line, a.windows, a.integrated) == (b.share_at.line, b.windows, b.integrated)


@given(st.lists(st.booleans(), min_size=1, max_size=120), st.lists(st.integers(0, 3000), max_size=4), st.floats(5, 90))
@settings(max_examples=30)
def test_windows_hold_every_sample_that_is_needed_once_wherever_the_course_is_cut(needed, cuts, period):
    flags = np.repeat(np.array(needed), round(period))
    n = len(flags)
    k = np.arange(n)
    course = Course(*(k.astype(float) for _ in range(6)), k)
    edges = [0, *sorted(min(c, n) for c in cuts), n]

    def windows(edges: list[int]) -> list[tuple[int, int]]:
        cutter = Windows(DT)
        found = [w for a, b in pairwise(edges) for w in cutter.add(course[a:b], flags[a:b])]
        return [(int(w.line[0]), int(w.line[-1])) for w in [*found, *cutter.finish()]]

    found = windows(edges)
    assert found == windows([0, n])
    inside = np.zeros(n, dtype=int)
    for first, last in found:
        inside[first : last + 1] += 1
    assert (inside[flags] == 1).all() and inside.max(initial=0) <= 1
    assert all(last - first < 4.0 / DT for first, last in found)


def test_a_corexy_moves_both_motors_along_an_axis_and_one_along_a_diagonal():
    machine, move = printer("corexy", LIGHT_ROTOR, Load(0.5)), there(40.0, 150.0, 3000.0)
    a, b = told(along(0, move), machine).motors
    assert (a.name, b.name) == ("a", "b") and a.share == pytest.approx(b.share)
    cartesian = told(along(0, move), printer(motor=LIGHT_ROTOR, load=Load(0.5))).motors[0]
    assert a.share == pytest.approx(0.5 * cartesian.share, rel=0.01)
    diagonal = along(0, move)
    diagonal[:, 1] = diagonal[:, 0]
    a, b = told(diagonal, machine).motors
    assert a.share == pytest.approx(cartesian.share, rel=0.01) and b.share < 1e-9


def test_a_delta_lifts_its_weight_with_all_three_motors():
    machine = printer("delta", LIGHT_ROTOR, Load(0.6))
    x = np.zeros((300, 3))
    x[:, 2] = there(5.0, 50.0, 1000.0, rest=100)[:300] - MIDDLE
    three = told(x, machine).motors
    assert [one.name for one in three] == ["a", "b", "c"]
    assert [one.share for one in three] == pytest.approx([0.6 * (9.80665 + 1.0) / 3 * ARM / TORQUE] * 3, rel=0.01)


def test_beyond_a_deltas_reach_there_is_no_load_but_an_error():
    with pytest.raises(LimitError, match=r"line 1: X500\.000"):
        told(np.full((5, 3), 500.0), printer("delta"))


def test_a_profile_without_motors_has_no_figures():
    assert told(moves(3000.0), printer(motor=None, load=None)).motors == ()


def test_a_load_behind_a_soft_belt_is_not_felt_at_once():
    """A jump of the commanded speed swings the rotor alone, by jump / w; a rigid mass asks for all of the torque."""
    x = along(0, np.r_[np.full(100, MIDDLE), MIDDLE + 100.0 * DT * np.arange(300)])
    what = execution(x)
    still = replace(rigid(what), nozzle=np.full((len(x), 2), MIDDLE))
    machine = printer(load=HEAVY)
    motors = Motors(machine, DT)
    motors.add(still)
    soft, hard = motors.figures().motors[0], told(x, machine).motors[0]
    swing = 0.25 * MOTOR.full_steps * 2.0 * pi * 100.0 / MOTOR.mm_per_turn / rotor_of(MOTOR).w
    assert 0.75 * swing < soft.share < swing  # damped, and the jump takes a sample
    assert hard.share > 3.0 * soft.share


def test_who_watches_sees_the_highest_share():
    machine, seen = printer(load=LOAD), []
    motors = Motors(machine, DT, watch=lambda t, share, names: seen.append((t, share, names)))
    motors.add(rigid(execution(moves(3000.0))))
    figures = motors.figures()
    share = np.concatenate([one[1] for one in seen])
    assert share.max(axis=0) == pytest.approx([one.share for one in figures.motors])
    assert len(share) == len(moves(3000.0)) == sum(len(one[0]) for one in seen) and seen[0][2] == ("x",)
