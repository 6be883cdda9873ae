"""A rotor is a pendulum in the field: its frequency, its decay, its energy, and where it falls over."""

from dataclasses import replace
from math import asin, exp, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motor_cases import DT, MOTOR

from fbfcli.verify.microsteps import finest, quantised
from fbfcli.verify.rotor import Course, Rotor, rotor_of, swings, trace
from fbfcli.verify.rotor_bound import Bound
from fbfcli.verify.torque_speed import standstill_torque, torque_left

FINE = 1e-5  # s: samples that show an oscillation


def course(u: np.ndarray, g: float | np.ndarray = 1.0) -> Course:
    n = len(u)
    none = np.zeros(n)
    return Course(np.asarray(u, float), np.broadcast_to(g, n).astype(float), none, none, none, none, none.astype(int))


def swung(rotor: Rotor, what: Course, dt: float, stride: float = 0.25) -> tuple[np.ndarray, np.ndarray]:
    """phi and phi' [per sample] of one rotor, shape (n,) each."""
    rows = [(phi[0], slope[0]) for _, phi, slope in trace(rotor, [what], dt, stride)]
    return np.array(rows).T


def released(angle: float, seconds: float, dt: float) -> Course:
    """A load that holds the rotor at an angle, and is gone at once."""
    u = np.zeros(round(seconds / dt))
    u[0] = np.sin(angle)
    return course(u)


@given(st.floats(-500.0, 500.0), st.integers(1, 256), st.sampled_from([20.0, 32.0, 40.0]))
def test_a_position_is_rounded_by_half_a_microstep_at_most(q, microsteps, mm_per_turn):
    steps_per_mm = 200 * microsteps / mm_per_turn
    off = quantised(np.array([q]), steps_per_mm)[0] - q
    assert abs(off) <= 0.5 / steps_per_mm + 1e-9
    assert quantised(quantised(np.array([q]), steps_per_mm), steps_per_mm)[0] == pytest.approx(q + off, abs=1e-9)


def test_an_interpolating_drive_makes_finer_positions():
    assert finest(replace(MOTOR, interpolation=False)) == 16 and finest(MOTOR) == 256


@pytest.mark.parametrize("torque", [0.1, 0.59])
@pytest.mark.parametrize("inertia", [20e-7, 82e-7, 200e-7])
def test_a_small_oscillation_has_the_natural_frequency(torque, inertia):
    """sqrt(p T / J) / (2 pi)."""
    motor = replace(MOTOR, holding_torque=torque, run_current=2.0, rotor_inertia=inertia, damping=0.0)
    frequency = sqrt(50 * torque / inertia) / (2 * pi)
    dt = 0.02 / frequency
    phi, _ = swung(rotor_of(motor), released(0.01, 20.5 / frequency, dt), dt)
    k = np.flatnonzero((phi[:-1] > 0.0) & (phi[1:] <= 0.0))
    falls = k + phi[k] / (phi[k] - phi[k + 1])
    assert len(falls) >= 20
    assert (len(falls) - 1) / ((falls[-1] - falls[0]) * dt) == pytest.approx(frequency, rel=1e-4)


@pytest.mark.parametrize("zeta", [0.01, 0.05, 0.3])
def test_an_oscillation_decays_as_its_damping_says(zeta):
    """Of a damped oscillator each swing is exp(-2 pi zeta / sqrt(1 - zeta^2)) of the one before."""
    rotor = Rotor(1500.0, zeta)
    phi, _ = swung(rotor, released(0.02, 0.02, FINE), FINE)
    peaks = phi[1:-1][(phi[1:-1] > phi[:-2]) & (phi[1:-1] >= phi[2:]) & (phi[1:-1] > 0)]
    assert len(peaks) >= 2
    assert peaks[1] / peaks[0] == pytest.approx(exp(-2 * pi * zeta / sqrt(1 - zeta**2)), rel=1e-3)


@given(st.floats(0.1, 1.5))
@settings(max_examples=20)
def test_without_damping_energy_stays(angle):
    """phi'^2 / 2 + w^2 (1 - cos phi), also of swings far beyond where a sine is straight."""
    w = 1500.0
    phi, slope = swung(Rotor(w, 0.0), released(angle, 200 * FINE, FINE), FINE, 0.02)
    energy = 0.5 * (slope / FINE) ** 2 + w**2 * (1.0 - np.cos(phi))
    assert np.ptp(energy[1:]) < 1e-6 * energy[1]


@given(st.floats(0.0, 0.95), st.floats(0.2, 1.0))
@settings(max_examples=20)
def test_a_constant_load_is_held_at_its_angle(u, g):
    """asin(T / T_max), and no angle at all without a load."""
    phi, _ = swung(rotor_of(MOTOR), course(np.full(50, u * g), g), DT)
    assert np.allclose(phi, asin(u), atol=1e-9)


@given(st.floats(0.05, 0.7))
@settings(max_examples=5)
def test_an_integration_converges_as_its_step_is_halved(u):
    rotor, what = Rotor(1500.0, 0.05), course(np.r_[0.0, np.full(30, u)])
    exact, _ = swung(rotor, what, DT, 0.02)
    errors = [np.abs(swung(rotor, what, DT, stride)[0] - exact).max() for stride in (0.4, 0.2, 0.1)]
    assert errors[1] < errors[0] / 8 + 1e-9 and errors[2] < errors[1] / 8 + 1e-9
    assert errors[1] < 2e-3


def test_a_sudden_load_topples_an_undamped_rotor_beyond_the_equal_area_limit():
    """1 - cos(phi) = u phi at sin(phi) = u: u = 0.7246, of a pendulum that is pushed from rest."""
    rotor = Rotor(1500.0, 0.0)
    below, above = (swings(rotor, [course(np.r_[0.0, np.full(300, u)])], 1e-4) for u in (0.72, 0.73))
    assert len(below.slips) == 0 and below.largest[0] < pi
    assert len(above.slips) > 0 and (above.slips[:, 2] == 1).all() and above.largest[0] == pi


def test_rows_of_different_length_do_not_touch_each_other():
    rng = np.random.default_rng(1)
    courses = [course(0.4 * rng.normal(size=n)) for n in (30, 200, 2, 77)]
    rotor = rotor_of(MOTOR)
    together = swings(rotor, courses, DT)
    for i, one in enumerate(courses):
        alone = swings(rotor, [one], DT)
        assert alone.largest[0] == pytest.approx(together.largest[i], rel=1e-12) and alone.at[0] == together.at[i]


@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.45), st.floats(5.0, 150.0), st.floats(0.02, 0.2))
@settings(max_examples=20)
def test_no_rotor_swings_further_than_its_bound(seed, size, frequency, zeta):
    """A load that swings at `frequency` and jumps. The sine's softness costs 5 % at most with a bound below 0.8."""
    rng = np.random.default_rng(seed)
    rotor = Rotor(1500.0, zeta)
    t = np.arange(250) * DT
    u = size * np.sin(2 * pi * frequency * t + rng.uniform(0, 6)) * (t > 0.02)
    u[rng.integers(50, 200) :] += size * rng.uniform(-1, 1)
    bound = Bound(rotor, DT).add(u)
    phi, _ = swung(rotor, course(u), DT)
    if bound.max() < 0.8:
        assert np.abs(phi).max() <= 1.05 * asin(bound.max()) + 1e-9


@given(st.floats(0.01, 0.25))
def test_the_bound_of_a_load_that_jumps_is_twice_and_of_one_that_turns_thrice(u):
    rotor = Rotor(1500.0, 0.0)
    up = np.r_[np.zeros(5), np.full(50, u)]
    turned = np.r_[u * np.minimum(np.arange(3000) / 2900, 1.0), np.full(50, -u)]
    assert Bound(rotor, 1e-4).add(up).max() == pytest.approx(2 * u, rel=1e-2)
    assert Bound(rotor, 1e-4).add(turned)[-45:].max() == pytest.approx(3 * u, rel=1e-2)


def test_torque_is_that_of_the_current_until_the_voltage_gives_out():
    w = np.linspace(0.0, 400.0, 2000)
    left = torque_left(MOTOR, w)
    assert left[0] == 1.0 and (np.diff(left) <= 1e-12).all() and left[-1] < 0.5
    assert standstill_torque(MOTOR) == pytest.approx(0.59 / 2)


@given(st.floats(1.0, 300.0), st.floats(12.0, 60.0))
def test_more_voltage_never_takes_torque(w, volts):
    more = torque_left(replace(MOTOR, supply_voltage=volts * 1.2), np.array([w]))
    assert more >= torque_left(replace(MOTOR, supply_voltage=volts), np.array([w]))


@given(st.floats(1.0, 400.0), st.floats(0.0, 2 * pi))
def test_no_angle_of_the_voltage_gives_more_torque_than_its_equation(w, angle):
    """The phasor equation of a phase, V = (R + i p w L) I + i K w, solved for an angle at random."""
    K, Z = 0.59 / (sqrt(2) * 2.0), 1.4 + 1j * 50 * w * 3e-3
    current = (24.0 * np.exp(1j * angle) - 1j * K * w) / Z
    unlimited = replace(MOTOR, run_current=2.9)  # standstill torque above what is compared
    best = torque_left(unlimited, np.array([w]))[0] * standstill_torque(unlimited)
    if K * current.imag < standstill_torque(unlimited):
        assert K * current.imag <= best + 1e-3 * standstill_torque(unlimited) + 1e-12
