"""What the firmwares allow at corners: worked examples, and the planners' facts one move at a time."""

import numpy as np
import pytest
from hypothesis import given, settings
from random_moves import moves_of, paths
from scalar_planners import marlin_classic_corner

from fbfcli.motion.junctions import corner_limits
from fbfcli.printer import FIRMWARES, Limits

RIGHT_ANGLE = [[50, 0, 0, 0], [0, 50, 0, 0]]
S = np.sqrt(0.5)  # cos(phi / 2) of a right angle


def test_klipper_takes_a_right_angle_at_the_square_corner_velocity():
    moves = moves_of(RIGHT_ANGLE, limits=Limits(square_corner_velocity=7.0))
    assert corner_limits(moves, "klipper").entry[1] == pytest.approx(7.0**2)


def test_klipper_arcs_touch_no_further_than_mid_move():
    a, d = 3000.0, 0.02
    moves = moves_of([[d, 0, 0, 0], [0, d, 0, 0]], limits=Limits(acceleration=a, square_corner_velocity=50.0))
    assert corner_limits(moves, "klipper").entry[1] == pytest.approx(0.5 * d * a)  # tan(45 deg) = 1


def test_klipper_extruder_step_limits_a_straight_corner():
    moves = moves_of([[50, 0, 0, 1], [50, 0, 0, 3]], limits=Limits(jerk=(9, 9, 9, 1.0)))
    assert corner_limits(moves, "klipper").entry[1] == pytest.approx((1.0 / 0.04) ** 2)


def test_klipper_stops_between_toolhead_and_extruder():
    moves = moves_of([[50, 0, 0, 0], [0, 0, 0, -1], [50, 0, 0, 0]])
    assert corner_limits(moves, "klipper").entry.tolist() == [0.0, 0.0, 0.0]


def test_klipper_caps_lifts_and_wipes():
    limits = Limits(velocity=300, axis_velocity=(9e9, 9e9, 10.0, 30.0), axis_acceleration=(9e9, 9e9, 100.0, 900.0))
    moves = moves_of([[0, 0, 1, 0], [3, 0, 4, 0], [10, 0, 0, -5], [0, 0, 0, 2]], 400.0, limits)
    corners = corner_limits(moves, "klipper")
    np.testing.assert_allclose(np.sqrt(corners.cruise), [10.0, 10.0 * 5 / 4, 30.0 * 2, 30.0])
    np.testing.assert_allclose(corners.accel, [100.0, 100.0 * 5 / 4, 900.0 * 2, 900.0])


def test_marlin_junction_deviation_at_a_right_angle():
    axis_a = (500.0, 9000.0, 9000.0, 9000.0)
    limits = Limits(travel_acceleration=1000.0, axis_acceleration=axis_a, junction_deviation=0.02)
    corners = corner_limits(moves_of(RIGHT_ANGLE, 200.0, limits), "marlin")
    assert corners.accel.tolist() == [500.0, 1000.0]
    assert corners.entry[1] == pytest.approx(500.0 / S * 0.02 * S / (1 - S))  # X carries sqrt(1/2) of the turn


def test_marlin_junction_deviation_follows_arcs_of_short_segments():
    d, phi, a = 0.1, 0.2, 1000.0
    limits = Limits(travel_acceleration=a, junction_deviation=0.02)
    moves = moves_of([[d, 0, 0, 0], [d * np.cos(phi), d * np.sin(phi), 0, 0]], 200.0, limits)
    assert corner_limits(moves, "marlin").entry[1] == pytest.approx(a * d / phi)


def test_marlin_reverses_at_the_minimum_planner_speed():
    moves = moves_of([[50, 0, 0, 0], [-50, 0, 0, 0]], limits=Limits(junction_deviation=0.02))
    assert corner_limits(moves, "marlin").entry[1] == pytest.approx(0.05**2)


def test_marlin_axis_limits_scale_with_the_direction():
    axis_v, axis_a = (30.0, 80.0, 9e9, 9e9), (300.0, 800.0, 9e9, 9e9)
    limits = Limits(axis_velocity=axis_v, axis_acceleration=axis_a, retract_acceleration=77.0)
    corners = corner_limits(moves_of([[3, 4, 0, 0], [0, 0, 0, -2]], 100.0, limits), "marlin")
    assert corners.cruise[0] == pytest.approx(50.0**2)
    assert corners.accel.tolist() == pytest.approx([500.0, 77.0])


@settings(deadline=None)
@given(paths(junction_deviation=np.nan))
def test_marlin_classic_jerk_agrees_with_the_move_by_move_planner(moves):
    v = np.sqrt(corner_limits(moves, "marlin").entry)
    for i in range(1, len(moves)):
        assert v[i] == pytest.approx(0.0 if moves.stop[i] else marlin_classic_corner(moves, i), abs=1e-9)


def test_reprapfirmware_jerk_per_axis():
    limits = Limits(jerk=(10.0, 6.0, 1.0, 1.0))
    assert corner_limits(moves_of(RIGHT_ANGLE, limits=limits), "reprapfirmware").entry[1] == pytest.approx(36.0)


def test_reprapfirmware_stops_between_printing_and_travel():
    moves = moves_of([[50, 0, 0, 1], [50, 0, 0, 0], [50, 0, 0, 0]], limits=Limits(jerk=(10.0, 10.0, 1.0, 9.0)))
    assert corner_limits(moves, "reprapfirmware").entry.tolist() == [0.0, 0.0, 100.0**2]


def test_reprapfirmware_m204_is_for_moves_in_the_plane():
    limits = Limits(acceleration=700.0, travel_acceleration=900.0, axis_acceleration=(5e3, 5e3, 50.0, 400.0))
    moves = moves_of([[9, 0, 0, 1e-3], [9, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], limits=limits)
    assert corner_limits(moves, "reprapfirmware").accel.tolist() == pytest.approx([700.0, 900.0, 50.0, 400.0])


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths())
def test_corners_never_exceed_either_cruise_speed(firmware, moves):
    corners = corner_limits(moves, firmware)
    floor = 0.05**2 * 1.001  # Marlin's minimum planner speed
    assert corners.entry[0] == 0.0 and not corners.entry[moves.stop].any()
    slower = np.minimum(corners.cruise[1:], corners.cruise[:-1])
    assert (corners.entry[1:] <= np.maximum(slower * (1 + 1e-12), floor)).all()
    assert (corners.smooth <= corners.accel).all()


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths())
def test_the_move_before_is_the_same_in_another_block(firmware, moves):
    whole = corner_limits(moves, firmware).entry
    for i in range(1, len(moves)):
        assert corner_limits(moves[i:], firmware, previous=moves[i - 1:i]).entry[0] == whole[i]
