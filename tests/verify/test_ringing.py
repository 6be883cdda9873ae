"""Corners of known shapes, and the ringing of a plant that is known in closed form."""

from itertools import pairwise

import numpy as np
import pytest
from execution_cases import DT, RIGID, cut, execution, mode
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.verify.passages import Passages
from fbfcli.verify.ringing import Corner, Ringing


def l_shape(v: float = 100.0, angle: float = 90.0, length: float = 60.0) -> np.ndarray:
    """Along X at constant speed, then `angle` degrees to the left, no slower: the corner at (length, 0)."""
    s = np.arange(0.0, 2 * length, v * DT)
    r = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    return 10.0 + np.where((s < length)[:, None], s[:, None] * [1.0, 0.0], [length, 0.0] + (s - length)[:, None] * r)


def corners_of(plants, pieces) -> list[Corner]:
    machine, ringing = Passages(plants), Ringing()
    passages = [p for p in [*(machine.add(piece) for piece in pieces), machine.finish()] if p is not None]
    found = [*(ringing.add(passage) for passage in passages), ringing.finish()]
    return [each for each in found if each is not None]


@settings(max_examples=12)
@given(st.floats(20.0, 60.0), st.floats(0.02, 0.1), st.floats(40.0, 150.0))
def test_the_ringing_of_one_mode_after_a_sharp_corner_is_that_of_theory(frequency, zeta, v):
    """Into the corner at a constant v the nozzle lags by 2 zeta v / w; X, left alone, then swings freely from there.

    With e = x - L: e(0) = -2 zeta v / w, e'(0) = v.
    """
    w = 2 * np.pi * frequency
    long = 8 * v / (zeta * w)  # what the start excited is over
    [found] = corners_of(mode(frequency, zeta), [execution(l_shape(v, length=long))])
    w_d = w * np.sqrt(1 - zeta**2)
    t = np.arange(0.0, 0.2, 1e-5)
    e0 = -2 * zeta * v / w
    e = np.exp(-zeta * w * t) * (e0 * np.cos(w_d * t) + (v + zeta * w * e0) / w_d * np.sin(w_d * t))
    zero = np.flatnonzero(e[1:] * e[:-1] < 0)
    first = np.abs(e[zero[0] : zero[1]]).max()
    assert len(found) == 1
    np.testing.assert_allclose(found.point[0], [10.0 + long, 10.0], atol=1e-9)
    assert found.turn[0] == pytest.approx(np.pi / 2)
    assert found.frequency[0] == pytest.approx(w_d / (2 * np.pi), rel=0.02)
    assert found.wavelength[0] == pytest.approx(v / (w_d / (2 * np.pi)), rel=0.02)
    assert found.overshoot[0] == pytest.approx(e.max(), rel=0.05)
    assert found.amplitude[0] == pytest.approx(first, rel=0.05)
    assert found.decay[0] == pytest.approx(np.exp(-zeta * w * np.pi / w_d), rel=0.03)
    assert found.axis[0] == 0


@given(st.floats(25.0, 170.0))
def test_a_rigid_machine_draws_corners_as_they_are(angle):
    [found] = corners_of(RIGID, [execution(l_shape(angle=angle))])
    assert len(found) == 1 and found.turn[0] == pytest.approx(np.radians(angle), abs=1e-6)
    for each in (found.rounding, found.overshoot, found.amplitude):
        assert each[0] < 1e-6
    assert np.isnan(found.wavelength[0])


def test_going_straight_back_overshoots_straight_on():
    [found] = corners_of(mode(40.0, 0.05), [execution(l_shape(angle=180.0))])
    assert len(found) == 1 and found.overshoot[0] > 0.05
    assert found.turn[0] == pytest.approx(np.pi)


def test_a_corner_that_is_cut_is_rounded():
    """A heavily damped machine, far slower than the path, never comes near the corner."""
    [soft] = corners_of(mode(10.0, 0.9), [execution(l_shape())])
    [stiff] = corners_of(mode(80.0, 0.9), [execution(l_shape())])
    assert soft.rounding[0] > 5 * stiff.rounding[0] > 0.1


@pytest.mark.parametrize("angle", [0.0, 5.0])
def test_almost_straight_on_is_no_corner(angle):
    assert corners_of(RIGID, [execution(l_shape(angle=angle))]) == []


def test_a_travel_move_after_it_is_no_wall():
    path = l_shape()
    extruding = np.arange(len(path)) < len(path) // 2 - 5
    assert corners_of(mode(40.0, 0.1), [execution(path, extruding=extruding)]) == []


@settings(max_examples=12)
@given(st.lists(st.integers(1, 3599), max_size=5))
def test_cuts_change_nothing(cuts):
    side = l_shape()
    path = np.vstack([side, side[-1] + side - side[0], side[-1] - side[0] + side[-1] - (side - side[0])])
    whole = execution(path, line=np.arange(len(path)))
    n = len(path)
    pieces = [cut(whole, a, b) for a, b in pairwise(np.unique([0, *np.minimum(cuts, n - 1), n]).tolist())]
    one, many = (corners_of(mode(40.0, 0.1), parts) for parts in ([whole], pieces))
    for name in Corner.__dataclass_fields__:
        a, b = (np.concatenate([getattr(each, name) for each in found]) for found in (one, many))
        np.testing.assert_allclose(b, a, rtol=1e-6, atol=1e-9, err_msg=name)
    assert sum(map(len, one)) >= 4
