"""Klipper's TEST_RESONANCES: a square wave of acceleration whose frequency rises.

Facts: klippy/extras/resonance_tester.py. Each frequency f lasts half a period, in two quarters t = 1/(4f) of
acceleration +-accel_per_hz f; the next f is 2 t hz_per_sec higher.
- Before the end of 2024 a half period is two moves of length a t^2 / 2, out from the centre and back: the planner
  brakes, then accelerates, and only the first and the last move are from rest to rest.
- Since then the moves are laid out in time, and a slow square wave of `sweeping_accel` may be added to them, so that
  the machine moves a few centimetres to and fro.
"""

from __future__ import annotations

import numpy as np

from fbfcli.plant.excitation import Sweep, piecewise

LAST = 1e-6  # by which the highest frequency may be passed
FIRST_TURN = np.sqrt(2) / 8  # of a period: the slow wave starts in the middle of its way
MOST_HALVES = 200_000


def klipper_test(
    f0: float = 5.0,
    f1: float = 135.0,
    accel_per_hz: float = 60.0,
    hz_per_sec: float = 1.0,
    sweeping_accel: float = 400.0,
    sweeping_period: float = 1.2,
) -> Sweep:
    """The test since the end of 2024; without the slow wave where its period or acceleration is 0."""
    f = frequencies(f0, f1, hz_per_sec)
    sign = np.where(np.arange(len(f)) % 2, -1.0, 1.0) * accel_per_hz * f
    length, a = np.repeat(0.25 / f, 2), np.column_stack([sign, -sign]).ravel()
    if sweeping_accel and sweeping_period:
        length, a = _with_slow_wave(length, a, sweeping_accel, sweeping_period)
    return Sweep("Klipper TEST_RESONANCES", float(length.sum()), f0, f1, piecewise(length, a))


def klipper_test_2020(
    f0: float = 5.0, f1: float = 133.33, accel_per_hz: float = 75.0, hz_per_sec: float = 1.0
) -> Sweep:
    """The test from 2020 to 2024."""
    f = frequencies(f0, f1, hz_per_sec)
    t, a = 0.25 / f, np.where(np.arange(len(f)) % 2, -1.0, 1.0) * accel_per_hz * f
    rest = t / np.sqrt(2)  # from rest to rest, a t^2 / 2 takes half of it to speed up and half to brake
    length = np.column_stack([t, t]).ravel()
    size = np.column_stack([-a, -a]).ravel()
    length = np.concatenate([[rest[0], rest[0]], length[1:-1], [rest[-1], rest[-1]]])
    size = np.concatenate([[a[0], -a[0]], size[1:-1], [-a[-1], a[-1]]])
    return Sweep("Klipper TEST_RESONANCES before 2025", float(length.sum()), f0, f1, piecewise(length, size))


def frequencies(f0: float, f1: float, hz_per_sec: float) -> np.ndarray:
    """f of each half period, f_(i+1) = f_i + hz_per_sec / (2 f_i), to f1."""
    found = [f0]
    while found[-1] <= f1 + LAST and len(found) < MOST_HALVES:
        found.append(found[-1] + 0.5 * hz_per_sec / found[-1])
    return np.array(found[:-1])


def _with_slow_wave(length: np.ndarray, a: np.ndarray, slow: float, period: float) -> tuple[np.ndarray, np.ndarray]:
    """The pieces cut at the turns of the slow square wave, and that added to them.

    It turns first after sqrt(2)/8 of its period, then after sqrt(2)/8 + 1/4, then every half: so it stays around the
    place where it started.
    """
    edge = np.concatenate([[0.0], np.cumsum(length)])
    turns = (FIRST_TURN + np.concatenate([[0.0], FIRST_TURN + 0.25 + 0.5 * np.arange(2 * edge[-1] / period)])) * period
    every = np.union1d(edge, turns[turns < edge[-1]])
    middle = 0.5 * (every[1:] + every[:-1])
    fast = a[np.searchsorted(edge, middle) - 1]
    sign = np.where(np.searchsorted(turns, middle) % 2, -1.0, 1.0)
    return np.diff(every), fast + slow * sign
