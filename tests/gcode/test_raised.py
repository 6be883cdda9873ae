"""Laws of raised limits: what the lines say is what the planner model sees; moves of Z and E alone keep theirs."""

from math import inf, isnan, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reading_cases import block_of

from fbfcli.gcode.raised import E_ACCELERATION, raise_lines, raised, restore_lines, shaper_off
from fbfcli.printer import FIRMWARES, Limits

speeds, corners = st.floats(1, 999), st.floats(0.1, 30)


@st.composite
def limits(draw: st.DrawFn, firmware: str) -> Limits:
    """Limits as a profile and a file may set them; deviation and jerk exclude each other."""
    deviation = draw(st.sampled_from((nan, 0.02))) if firmware == "marlin" else nan
    top = draw(st.sampled_from((inf, 250.0)))
    return Limits(
        velocity=draw(speeds),
        acceleration=draw(st.floats(50, 30000)),
        travel_acceleration=draw(st.floats(50, 30000)),
        axis_velocity=(draw(speeds), top, 10.0, 40.0),
        axis_acceleration=(draw(st.floats(100, 9000)), top, 100.0, 4000.0),
        jerk=(draw(corners), draw(corners), 0.4, 2.0),
        junction_deviation=deviation,
        square_corner_velocity=draw(corners),
        minimum_cruise_ratio=draw(st.sampled_from((0.0, 0.5))),
    )


def in_force(lines: list[str], firmware: str) -> Limits:
    block = block_of("\n".join([*lines, ""]), firmware)
    return block.moves.limits[block.state[-1]]


READ = {
    "klipper": ("velocity", "acceleration", "square_corner_velocity", "minimum_cruise_ratio"),
    "marlin": ("acceleration", "travel_acceleration"),
    "reprapfirmware": ("acceleration", "travel_acceleration"),
}
PER_AXIS = ("axis_velocity", "axis_acceleration", "jerk")


def same(firmware: str, found: Limits, wanted: Limits, axes: int) -> None:
    """In all that the firmware reads, of the first so many axes."""
    for name in READ[firmware]:
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), rtol=1e-5, err_msg=name)
    for name in PER_AXIS if firmware != "klipper" else ():
        if name == "jerk" and not isnan(wanted.junction_deviation):
            continue
        np.testing.assert_allclose(getattr(found, name)[:axes], getattr(wanted, name)[:axes], rtol=1e-5, err_msg=name)
    if firmware == "marlin" and not isnan(wanted.junction_deviation):
        assert found.junction_deviation == pytest.approx(wanted.junction_deviation, rel=1e-5)


@pytest.mark.parametrize("firmware", FIRMWARES)
@given(st.data())
def test_lines_put_in_force_what_they_were_made_for(firmware, data):
    wanted = data.draw(limits(firmware))
    same(firmware, in_force(restore_lines(firmware, wanted, Limits()), firmware), wanted, 4)
    same(firmware, in_force(raise_lines(firmware, wanted), firmware), raised(firmware, wanted), 2)


@given(st.data())
def test_marlin_takes_e_along_and_puts_it_back(data):
    wanted = data.draw(limits("marlin"))
    up = raise_lines("marlin", wanted)
    assert in_force(up, "marlin").axis_acceleration[3] == E_ACCELERATION
    assert in_force([*up, *restore_lines("marlin", wanted, wanted)], "marlin").axis_acceleration[3] == 4000.0


@pytest.mark.parametrize("firmware", FIRMWARES)
@given(st.data())
def test_what_did_not_change_in_z_and_e_is_not_told(firmware, data):
    wanted = data.draw(limits(firmware))
    lines = raise_lines(firmware, wanted) + restore_lines(firmware, wanted, wanted)
    told = ("M203", "M205", "M566") if firmware == "marlin" else ("M201", "M203", "M205", "M566")
    assert not [line for line in lines if line.startswith("M201") and "Z" in line]
    assert not [line for line in lines if line.startswith(told) and ("Z" in line or "E" in line)]


@pytest.mark.parametrize("firmware", FIRMWARES)
@given(st.data())
def test_x_and_y_are_raised_and_moves_of_z_and_e_alone_keep_theirs(firmware, data):
    before = data.draw(limits(firmware))
    after = raised(firmware, before)
    assert after.acceleration >= before.acceleration and after.velocity >= before.velocity
    assert after.square_corner_velocity >= before.square_corner_velocity
    for name in PER_AXIS:
        own, high = getattr(before, name), getattr(after, name)
        assert high[2] == own[2]
        assert high[3] == own[3] or (firmware == "marlin" and name == "axis_acceleration")
        assert all(b >= a for a, b in zip(own[:2], high[:2], strict=True))
    assert raised(firmware, after) == after
    assert after.retract_acceleration == before.retract_acceleration


@pytest.mark.parametrize("firmware", FIRMWARES)
@given(st.data())
def test_numbers_have_no_exponent_and_no_infinity(firmware, data):
    """Firmwares read 1e8 as 1."""
    wanted = data.draw(limits(firmware))
    for line in raise_lines(firmware, wanted) + restore_lines(firmware, wanted, Limits()):
        values = [word.split("=")[-1].lstrip("PTRXYZEJBFS") for word in line.split()[1:]]
        assert all(set(value) <= set("0123456789.") and value for value in values if '"' not in value), line


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_the_firmwares_own_shaper_is_switched_off_once_at_the_rise(firmware):
    lines = raise_lines(firmware, Limits(axis_velocity=(9, 9, 9, 9), axis_acceleration=(9, 9, 9, 9), jerk=(9, 9, 9, 9)))
    assert lines[: len(shaper_off(firmware))] == shaper_off(firmware)
    assert not set(shaper_off(firmware)) & set(restore_lines(firmware, Limits(), Limits()))


def test_an_unlimited_axis_is_not_told():
    """It could not be put back."""
    lines = restore_lines("marlin", Limits(), Limits())
    assert not [line for line in lines if line.startswith(("M201", "M203", "M205 X"))]
