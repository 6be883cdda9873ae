"""Laws of the trapezoids."""

import numpy as np
import pytest
from hypothesis import given, settings
from random_moves import moves_of, paths

from fbfcli.motion.junctions import corner_limits
from fbfcli.motion.lookahead import Plan, plan
from fbfcli.motion.profile import Profile, profile
from fbfcli.printer import FIRMWARES, Limits


def profile_of(moves, firmware: str = "klipper") -> Profile:
    return profile(plan(corner_limits(moves, firmware), moves.distance))


def test_a_long_move_takes_d_over_v_plus_v_over_a():
    p = profile_of(moves_of([[100.0, 0, 0, 0]], 100.0, Limits(acceleration=1000.0, minimum_cruise_ratio=0.0)))
    assert p.duration[0] == pytest.approx(100 / 100 + 100 / 1000)
    assert p.t_accel[0] == p.t_decel[0] == pytest.approx(0.1)


def test_a_short_move_is_a_triangle():
    p = profile_of(moves_of([[0.1, 0, 0, 0]], 400.0, Limits(acceleration=1000.0, minimum_cruise_ratio=0.0)))
    assert p.t_cruise[0] == pytest.approx(0.0, abs=1e-12)
    assert p.duration[0] == pytest.approx(2 * np.sqrt(0.1 / 1000.0))


@pytest.mark.parametrize("firmware", FIRMWARES)
@settings(deadline=None)
@given(moves=paths())
def test_distance_time_and_acceleration(firmware, moves):
    p = profile_of(moves, firmware)
    ramps = (p.v_start + p.v_cruise) / 2 * p.t_accel + (p.v_end + p.v_cruise) / 2 * p.t_decel
    np.testing.assert_allclose(ramps + p.v_cruise * p.t_cruise, moves.distance, rtol=1e-12)
    np.testing.assert_array_equal(p.duration, p.t_accel + p.t_cruise + p.t_decel)
    assert min(p.t_accel.min(), p.t_cruise.min(), p.t_decel.min()) >= 0.0
    slack = 1e-9 * p.v_cruise.max()
    assert (p.v_cruise - p.v_start <= p.accel * p.t_accel * (1 + 1e-9) + slack).all()
    assert (p.v_cruise - p.v_end <= p.accel * p.t_decel * (1 + 1e-9) + slack).all()


def test_rounding_and_rest_leave_no_negative_or_missing_times():
    w = np.array([100.0, 0.0])
    p = profile(Plan(np.array([0.05 * (1 - 1e-10), 0.0]), np.full(2, 1000.0), np.zeros(2), w, w))
    np.testing.assert_allclose(p.duration, [0.01, 0.0], rtol=1e-9)
    assert p.t_cruise.tolist() == [0.0, 0.0]
