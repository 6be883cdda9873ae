"""Limits are kept once, and only X and Y are planned differently."""

from hypothesis import given
from hypothesis import strategies as st

from fbfcli.motion.limit_table import LimitTable, compensated
from fbfcli.printer import Limits

limits = st.builds(lambda a, v: Limits(acceleration=float(a), velocity=float(v)), st.integers(1, 6), st.integers(1, 6))


@given(st.lists(st.lists(limits, max_size=6), max_size=8))
def test_an_index_stands_for_its_limits_for_ever(batches):
    table, given_out = LimitTable(), []
    for batch in batches:
        index = table.index(tuple(batch))
        assert index.shape == (len(batch),)
        given_out += zip(index.tolist(), batch, strict=True)
        assert all(table.limits[i] == one for i, one in given_out)
    assert len(set(table.limits)) == len(table.limits) == len({one for _, one in given_out})


@given(limits, st.one_of(st.none(), st.floats(1, 30000)), st.one_of(st.none(), st.floats(1, 900)))
def test_compensated_moves_are_planned_as_asked_in_x_and_y(one, acceleration, velocity):
    found = compensated(one, acceleration, velocity)
    assert found.acceleration == (one.acceleration if acceleration is None else acceleration)
    assert found.velocity == (one.velocity if velocity is None else velocity)
    if acceleration is not None:
        assert found.travel_acceleration == acceleration and min(found.axis_acceleration[:2]) >= acceleration
    if velocity is not None:
        assert max(found.axis_velocity[:2]) <= velocity
    assert (found.axis_acceleration[2], found.axis_velocity[2]) == (one.axis_acceleration[2], one.axis_velocity[2])
    assert (found.jerk, found.square_corner_velocity) == (one.jerk, one.square_corner_velocity)


@given(st.floats(1, 200), st.floats(10, 9000))
def test_e_is_planned_with_a_margin(velocity, acceleration):
    """Chords are a little faster than the curve that they stand for."""
    one = Limits(axis_velocity=(300.0, 300.0, 20.0, velocity), axis_acceleration=(9e3, 9e3, 500.0, acceleration))
    found = compensated(one, None, None)
    assert found.axis_velocity[3] < velocity and found.axis_acceleration[3] < acceleration
    assert found.axis_velocity[:3] == one.axis_velocity[:3] and found.axis_acceleration[:3] == one.axis_acceleration[:3]
