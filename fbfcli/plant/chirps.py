"""Sweeps of sines in position, as Marlin's fixed-time motion makes them: its own test, and Ulendo's.

p position [mm], m envelope, phi phase [rad], c sweep rate [Hz/s], tau time since the sweep began [s]
"""

from __future__ import annotations

import numpy as np

from fbfcli.plant.excitation import Sweep, piecewise

RUN_IN = 1.0  # s in which Ulendo's amplitude grows as tau^3
HIGHEST = 1e3  # Hz, of any sweep
TURN = 2 * np.pi


def marlin_test(
    f0: float = 5.0, f1: float = 100.0, octave: float = 40.0, accel_per_hz: float = 60.0, correction: float = 5.0
) -> Sweep:
    """M495: p = C A / (4 pi^2 f) sin(2 pi f t), f = f0 2^(t / octave): Marlin's ft_motion/trajectory_resonance.cpp.

    The phase is f t and not the integral of f, so the frequency that the machine sees is f (1 + t ln 2 / octave).
    """
    duration = octave * np.log2(f1 / f0)
    growth = np.log(2) / octave  # f' = growth f
    size = correction * accel_per_hz / (4 * np.pi**2)

    def velocity(t: np.ndarray) -> np.ndarray:
        f = f0 * np.exp(growth * np.clip(t, 0.0, duration))
        phi = TURN * f * t
        v = size * (TURN * (1 + growth * t) * np.cos(phi) - growth / f * np.sin(phi))
        return np.where((t >= 0) & (t < duration), v, 0.0)

    highest = f1 * (1 + duration * growth)
    return Sweep("Marlin M495", float(duration), f0, float(highest), velocity)


def ulendo_sweep(
    f0: float, f1: float, dfdt: float, a: float, step_ti: float, step_a: float, dly1_ti: float, dly2_ti: float,
    dly3_ti: float,
) -> Sweep:  # fmt: skip
    """Rest, a marker, rest, p = m a / phi'^2 sin(phi), rest, a marker the other way round.

    phi = pi c tau^2 + 2 pi (f0 - 1) tau: one second of running in, in which m = tau^3 grows to 1. Times in s. Facts:
    the plug-in's make_profile.
    """
    low = f0 - RUN_IN
    begin = dly1_ti + 4 * step_ti + dly2_ti
    end = begin + (f1 - low) / dfdt
    second = end + dly3_ti
    step = step_ti * np.array([1.0, 2.0, 1.0])
    lengths = np.concatenate([[dly1_ti], step, [second - dly1_ti - 4 * step_ti], step])
    pulse = step_a * np.array([1.0, -1.0, 1.0])
    markers = piecewise(lengths, np.concatenate([[0.0], pulse, [0.0], -pulse]))

    def velocity(t: np.ndarray) -> np.ndarray:
        tau = np.clip(t - begin, 0.0, end - begin)
        phi, rate = np.pi * dfdt * tau**2 + TURN * low * tau, TURN * (dfdt * tau + low)
        m, grows = np.minimum(tau**3, 1.0), np.where(tau < RUN_IN, 3 * tau**2, 0.0)
        size = m * a / rate**2
        change = grows * a / rate**2 - 2 * size * TURN * dfdt / rate
        v = change * np.sin(phi) + size * rate * np.cos(phi)
        return np.asarray(np.where((t > begin) & (t < end), v, 0.0) + markers(t))

    return Sweep("Ulendo's sweep", float(second + 4 * step_ti), f0, f1, velocity)
