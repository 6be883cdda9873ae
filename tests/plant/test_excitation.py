"""What known tests command, against independent ways of computing it."""

from __future__ import annotations

from math import floor, sqrt

import numpy as np
import pytest
from resonance_corpus import RESONANCE, needs_resonance

from fbfcli.errors import RecordingError
from fbfcli.motion.lookahead import plan_block
from fbfcli.motion.moves import Moves
from fbfcli.motion.profile import profile
from fbfcli.plant.alignment import command_at
from fbfcli.plant.chirps import marlin_test, ulendo_sweep
from fbfcli.plant.excitation import acceleration, piecewise, until
from fbfcli.plant.klipper_test import frequencies, klipper_test, klipper_test_2020
from fbfcli.plant.recordings import read_recordings
from fbfcli.plant.square_sweep import SweepSettings, swings
from fbfcli.plant.sweep_spec import SWEPT, named_sweep, sweep_csv, sweep_of_csv
from fbfcli.printer import Limits

ULENDO = {"f0": 5.0, "f1": 80.0, "dfdt": 4.0, "a": 4000.0, "step_ti": 0.05, "step_a": 4000.0, "dly1_ti": 0.5,
          "dly2_ti": 1.0, "dly3_ti": 1.0}  # fmt: skip
ALL = {
    "klipper": klipper_test(f1=60.0),
    "without the slow wave": klipper_test(f1=60.0, sweeping_period=0.0),
    "2020": klipper_test_2020(f1=60.0),
    "marlin": marlin_test(f1=40.0),
    "ulendo": ulendo_sweep(**ULENDO),
}
each_test = pytest.mark.parametrize("sweep", ALL.values(), ids=ALL)


@each_test
def test_the_machine_rests_before_and_after(sweep):
    np.testing.assert_array_equal(sweep.velocity(np.array([-1.0, -1e-9, sweep.duration + 1e-9, 1e6])), 0.0)


@each_test
def test_a_bed_holds_it(sweep):
    x = np.cumsum(sweep.velocity(np.arange(0, sweep.duration, 1e-4))) * 1e-4
    assert np.ptp(x) < 60.0


@each_test
def test_the_mean_acceleration_adds_up_to_the_velocity(sweep):
    dt = 1e-3
    t = np.arange(0.0, 0.6 * sweep.duration, dt)
    v = np.cumsum(acceleration(sweep, t, dt)) * dt
    np.testing.assert_allclose(v, sweep.velocity(t + 0.5 * dt) - sweep.velocity(-0.5 * dt), atol=1e-6)


@each_test
def test_a_sweep_that_is_cut_coasts(sweep):
    cut = until(sweep, 2.0)
    t = np.linspace(0, 1.99, 500)
    np.testing.assert_array_equal(cut.velocity(t), sweep.velocity(t))
    assert not acceleration(cut, np.linspace(2.01, 60.0, 500), 1e-3).any()


def test_the_frequency_of_klipper_rises_by_hz_per_sec():
    f = frequencies(5.0, 135.0, 1.0)
    t = np.cumsum(0.5 / f)
    assert np.abs(f[1:] - 5.0 - t[:-1]).max() < 0.01


def klipper_pieces(f0, f1, per_hz, slow, period):
    """Accelerations of the test since the end of 2024 with the time at which each ends, as its generator goes along."""
    pulses, f, sign, t = [], f0, 1.0, 0.0
    while f <= f1 + 1e-6:
        for way in (sign, -sign):
            t += 0.25 / f
            pulses.append((t, way * per_hz * f))
        f += 0.5 / f
        sign = -sign
    left, part, way, last, pieces = period * sqrt(2) / 8, sqrt(2) / 8 + 0.25, 1.0, 0.0, []
    for end, a in pulses:
        while left <= end - last:
            last += left
            pieces.append((last, a + way * slow))
            left, part, way = period * part, 0.5, -way
        left -= end - last
        pieces.append((end, a + way * slow))
        last = end
    return np.array(pieces)


def test_klipper_is_its_generator():
    pieces = klipper_pieces(5.0, 60.0, 60.0, 400.0, 1.2)
    ends = np.concatenate([[0.0], pieces[:, 0]])
    v = np.concatenate([[0.0], np.cumsum(np.diff(ends) * pieces[:, 1])])
    np.testing.assert_allclose(klipper_test(f1=60.0).velocity(ends[:-1]), v[:-1], atol=1e-6)


def test_klipper_before_2025_is_what_the_planner_makes_of_its_moves():
    f = frequencies(5.0, 40.0, 1.0)
    length = 75.0 * f / (32 * f**2)  # a t^2 / 2 with t = 1 / (4 f)
    sign = np.where(np.arange(len(f)) % 2, -1.0, 1.0)
    x = np.column_stack([sign * length, -sign * length]).ravel()
    n = len(x)
    delta = np.zeros((n, 4))
    delta[:, 0] = x
    start = np.zeros((n, 4))
    start[1:, 0] = np.cumsum(x)[:-1]
    limits = tuple(Limits(acceleration=75.0 * one, minimum_cruise_ratio=0.0) for one in f)
    moves = Moves(start, delta, np.full(n, 75.0 / 4), np.arange(n) == 0, np.repeat(np.arange(len(f)), 2), np.arange(n),
                  limits)  # fmt: skip
    plan, _ = plan_block(moves, "klipper", last=True)
    timing = profile(plan)
    phases = np.column_stack([timing.t_accel, timing.t_cruise, timing.t_decel])
    a = np.column_stack([timing.accel, np.zeros(n), -timing.accel]) * np.sign(x)[:, None]
    planned = piecewise(phases.ravel(), a.ravel())
    sweep = klipper_test_2020(f1=40.0)
    t = np.linspace(0, sweep.duration, 20_000)
    assert sweep.duration == pytest.approx(timing.duration.sum(), rel=1e-5)
    np.testing.assert_allclose(sweep.velocity(t), planned(t), atol=0.5)


def test_marlin_is_its_position_differentiated():
    t, h = np.linspace(0.1, 79.0, 4000), 1e-4

    def p(t):
        f = 5.0 * 2 ** (t / 40.0)
        return 5 * 60 / (4 * np.pi**2 * f) * np.sin(2 * np.pi * f * t)

    np.testing.assert_allclose(marlin_test().velocity(t), (p(t + h) - p(t - h)) / (2 * h), rtol=1e-3, atol=0.05)


def ulendo_position(t, c):
    """One sample of the plug-in's profile."""
    begin = c["dly1_ti"] + 4 * c["step_ti"] + c["dly2_ti"]
    tau = t - begin
    if not 0 < tau < (c["f1"] - c["f0"] + 1) / c["dfdt"]:
        return 0.0
    rate = 2 * np.pi * (c["dfdt"] * tau + c["f0"] - 1)
    return min(tau**3, 1.0) * c["a"] / rate**2 * np.sin(np.pi * c["dfdt"] * tau**2 + 2 * np.pi * (c["f0"] - 1) * tau)


def test_ulendo_is_its_position_differentiated():
    sweep = ulendo_sweep(**ULENDO)
    t, h = np.linspace(1.71, 20.69, 5000), 1e-5
    p = np.array([[ulendo_position(s + o, ULENDO) for s in t] for o in (-h, h)])
    np.testing.assert_allclose(sweep.velocity(t), (p[1] - p[0]) / (2 * h), rtol=1e-3, atol=0.02)


def test_ulendo_markers_are_a_square_wave():
    sweep = ulendo_sweep(**ULENDO)
    for begin, sign in ((0.5, 1.0), (sweep.duration - 0.2, -1.0)):
        a = acceleration(sweep, begin + np.array([0.02, 0.08, 0.12, 0.18, 0.22]), 1e-3)
        np.testing.assert_allclose(a, sign * 4000.0 * np.array([1, -1, -1, 1, 0]), atol=1e-6)


@needs_resonance
def test_ulendo_is_the_command_that_others_rebuilt():
    file = RESONANCE / "commanded_measured" / "ulendo_ender3v2neo_y_240529_143933_paired.csv"
    (pair,) = read_recordings(file.read_bytes(), file.name)
    inside = (pair.t > 1.0) & (pair.t < 20.6) & (np.abs(pair.t - 2.7) > 2e-3)  # at 2.7 s the amplitude's growth ends
    a = acceleration(ulendo_sweep(**ULENDO), pair.t, 1e-5)
    np.testing.assert_allclose(a[inside], pair.command[inside], atol=6.0)  # theirs by differences of positions


def test_the_sampled_command_keeps_the_spectrum_of_the_wave():
    """A square wave of 30 Hz: its harmonics below an eighth of the rate are 4 A / (pi k), odd k, at their phases."""
    fs, f, n = 1573.0, 30.0, 1573 * 4
    half = np.full(2 * 30 * 6, 0.5 / f)
    wave = piecewise(half, np.where(np.arange(len(half)) % 2, -1.0, 1.0))
    sweep = until(klipper_test(), 100.0)
    sampled = command_at(type(sweep)("wave", 6.0, f, f, wave), np.arange(n) / fs + 0.5, 1 / fs)
    for k in (1, 3, 5):
        t = np.arange(n) / fs + 0.5
        line = 2j * np.mean(sampled * np.exp(-2j * np.pi * k * f * t))
        assert line == pytest.approx(4 / (np.pi * k), rel=1e-3, abs=1e-3)


@pytest.mark.parametrize(("words", "told"), [
    ("kliper", "did you mean klipper"), ("klipper:fmax=3", "it has f0"), ("klipper:f1=x", "no number"),
    ("klipper:f1=-1", "must not be"), ("klipper:f1=nan", "must not be"), ("ulendo", "needs f0"), ("", "known are"),
    ("klipper:f0=0", "rise"), ("klipper:f0=50,f1=40", "rise"), ("klipper:hz_per_sec=0", "rise"),
    ("marlin:f0=120", "rise"), ("marlin:octave=0", "rise"),
    ("ulendo:f0=1,f1=80,dfdt=4,a=4000,step_ti=0.05,step_a=4000,dly1_ti=0.5,dly2_ti=1,dly3_ti=1", "rise"),
])  # fmt: skip
def test_a_test_that_is_misnamed_is_refused(words, told):
    with pytest.raises(RecordingError, match=told):
        named_sweep(words)


def test_tests_by_name():
    assert named_sweep("klipper:f1=60,accel_per_hz=75").velocity(np.array([1.0])) == klipper_test(
        f1=60.0, accel_per_hz=75.0).velocity(np.array([1.0]))  # fmt: skip
    assert named_sweep("marlin").duration == marlin_test().duration


def test_the_csv_of_a_command_is_read_as_it_was_written():
    edge, a = np.array([0.0, 0.5, 1.25, 2.0]), np.array([100.0, -200.0, 100.0, 0.0])
    about = SWEPT.format(200.0, 4.0, 60.0, 0.5, 1.25)
    back = sweep_of_csv(sweep_csv(edge, a, "x", [about]).encode(), "x.csv")
    t = np.linspace(-0.5, 2.5, 301)
    np.testing.assert_allclose(back.velocity(t), piecewise(np.diff(edge), a[:-1])(t), atol=1e-4)
    assert back.segments == ((0.5, 1.25, 200.0),)
    assert (back.f0, back.f1) == (4.0, 60.0)


def test_a_sampled_command_is_taken_as_the_mean_around_each_time():
    t = np.arange(400) / 1000.0
    text = "t,a\n" + "".join(f"{s},{np.sin(30 * s)}\n" for s in t)
    back = sweep_of_csv(text.encode(), "x.csv")
    np.testing.assert_allclose(acceleration(back, t[1:-1] + 0.5e-3, 1e-3), np.sin(30 * t[1:-1]), atol=1e-5)


@pytest.mark.parametrize("text", ["time_s,a\n0,1\n0,2\n1,3\n", "time_s,a\n0,0\n1,0\n2,0\n", "t,a,b\n0,1,2\n1,2,3\n",
                                  "x"])  # fmt: skip
def test_a_csv_that_commands_nothing_is_refused(text):
    with pytest.raises(RecordingError):
        sweep_of_csv(text.encode(), "x.csv")


SETTINGS = SweepSettings(5.0, 100.0, 4.0, (2000.0, 5000.0), 300.0, 0.02)


def test_our_own_swings_turn_back_every_time_and_keep_their_frequency():
    plan = swings(SETTINGS)
    assert (np.sign(plan.distance[1:]) == -np.sign(plan.distance[:-1])).all()
    for number, a in enumerate(SETTINGS.accelerations, 1):
        T = 2 * np.sqrt(np.abs(plan.distance[plan.part == number]) / a)
        f = 0.5 / T
        np.testing.assert_allclose(f[1:] - f[0], SETTINGS.rate * np.cumsum(T)[:-1], atol=0.25)
        assert f[0] == pytest.approx(5.0) and f[-1] <= min(100.0, sqrt(a / 0.02) / 4) + 0.1
    assert (np.sqrt(plan.acceleration * np.abs(plan.distance)) <= SETTINGS.velocity).all()
    assert np.abs(plan.distance[plan.part > 0]).min() > 0.99 * SETTINGS.shortest
    assert floor(np.abs(np.cumsum(plan.distance)).max()) < 40
