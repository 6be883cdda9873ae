"""Kinematics undo themselves, and give what can be computed by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.cli.lookup import find_printer
from fbfcli.errors import LimitError, ProfileError
from fbfcli.motion.kinematics import Cartesian, CoreXY, Delta, in_reach, kinematics_of

DELTA = Delta(radius=140.0, arm=300.0)
everyone = pytest.mark.parametrize("kinematics", [Cartesian(), CoreXY(), DELTA], ids=lambda k: type(k).__name__)
within = st.floats(-90.0, 90.0)


@everyone
@given(points=st.lists(st.tuples(within, within, st.floats(0.0, 300.0)), min_size=1, max_size=20))
def test_the_toolhead_is_where_its_motors_put_it(kinematics, points):
    x = np.array(points)
    assert np.allclose(kinematics.toolhead(kinematics.motors(x)), x, rtol=0, atol=1e-9)


def test_corexy_moves_one_belt_on_a_diagonal():
    assert CoreXY().motors(np.array([[3.0, 3.0, 1.0], [2.0, -2.0, 1.0]])).tolist() == [[6, 0, 1], [0, 4, 1]]


def test_a_deltas_carriages_stand_level_over_the_centre():
    height = np.sqrt(300.0**2 - 140.0**2)
    assert np.allclose(DELTA.motors(np.array([[0.0, 0.0, 5.0]])), 5.0 + height)


def test_under_a_tower_its_arm_hangs_straight():
    c = DELTA.motors(np.array([[0.0, 140.0, 0.0]]))[0, 2]  # the third tower stands at +Y
    assert c == pytest.approx(300.0)


def test_what_the_arms_cannot_reach_is_nan():
    q = DELTA.motors(np.array([[0.0, -170.0, 0.0], [0.0, 0.0, 0.0]]))
    assert np.isnan(q[0]).any()
    assert not np.isnan(q[1]).any()


def test_a_delta_needs_its_size():
    printer = replace(find_printer("synthetic_bed_slinger"), kinematics="delta")
    with pytest.raises(ProfileError, match="delta_radius and arm_length"):
        kinematics_of(printer)
    assert kinematics_of(replace(printer, delta_radius=140.0, arm_length=300.0)) == DELTA


@everyone
@given(
    at=st.tuples(within, within, st.floats(0.0, 300.0)),
    force=st.tuples(*[st.floats(-50.0, 50.0)] * 3),
    way=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
def test_motors_do_the_work_that_is_done_at_the_toolhead(kinematics, at, force, way):
    x, F, dx = np.array([at]), np.array([force]), 1e-4 * np.array([way])
    dq = kinematics.motors(x + dx) - kinematics.motors(x - dx)
    assert np.sum(kinematics.forces(x, F) * dq) == pytest.approx(np.sum(F * 2.0 * dx), rel=1e-6, abs=1e-9)


def test_where_the_arms_do_not_reach_the_line_is_told():
    with pytest.raises(LimitError, match=r"^line 8: X0\.000 Y400\.000 Z1\.000"):
        in_reach(DELTA, np.array([[0.0, 0.0, 1.0], [0.0, 400.0, 1.0]]), np.array([6, 7]))
