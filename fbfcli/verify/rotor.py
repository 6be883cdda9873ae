"""The rotor of a stepper, drawn along by the field.

theta_s field, theta rotor [rad of the shaft]; p rotor teeth, a quarter of the full steps; J inertia, T torque that is
left at the field's speed, T_0 at rest, tau load [N m]:

    J theta'' = T sin(p (theta_s - theta)) + D (theta_s' - theta') - tau

Damping is what windings and iron do against slip, so it pulls towards the field's speed; friction of the axis is load.
In phi = p (theta_s - theta), the electrical load angle, with w^2 = p T_0 / J, D = 2 zeta sqrt(J p T_0),
g = T / T_0 and u = (J theta_s'' + tau) / T_0, the torque that is wanted:

    phi'' = w^2 (u - g sin(phi + e)) - 2 zeta w phi'

e is what the field's microstep is off the commanded position. A full step is pi / 2 of phi. Where phi passes pi the
rotor falls to the next equilibrium, 2 pi or 4 full steps away, and the motor has lost them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, pi, sqrt

import numpy as np

from fbfcli.printer import Motor
from fbfcli.verify.microsteps import quantised
from fbfcli.verify.torque_speed import standstill_torque

STRIDE = 0.25  # rad of the rotor's own oscillation in a step of Runge and Kutta: its frequency is met within 1e-5
CYCLE = 2.0 * pi


@dataclass(frozen=True)
class Rotor:
    """w [rad/s] and zeta."""

    w: float
    zeta: float


@dataclass(frozen=True)
class Course:
    """What a rotor is asked for; n samples, and all of it linear between them.

    u, g   : ndarray, shape (n,)          torque wanted and torque left, of the standstill torque
    step   : ndarray, shape (n,)          position [microsteps of the field]
    ripple : ndarray, shape (n,)          a microstep in electrical angle [rad]; 0 where there are too many to feel
    speed  : ndarray, shape (n,)          of the axis [mm/s]
    time   : ndarray, shape (n,)          [s]
    line   : ndarray of int, shape (n,)   counted from 0
    """

    u: np.ndarray
    g: np.ndarray
    step: np.ndarray
    ripple: np.ndarray
    speed: np.ndarray
    time: np.ndarray
    line: np.ndarray

    def __len__(self) -> int:
        return len(self.u)

    def __getitem__(self, rows: slice) -> Course:
        """Some of them, without the rest held in memory: windows wait to be integrated together."""
        return Course(*(values[rows].copy() for values in vars(self).values()))


def joined(courses: Sequence[Course]) -> Course:
    """One after the other."""
    return Course(*(np.concatenate(column) for column in zip(*(vars(c).values() for c in courses), strict=True)))


@dataclass(frozen=True)
class Swings:
    """What rotors did, one on each of m courses.

    largest : ndarray, shape (m,)             largest load angle, pi at most [rad, electrical]
    at      : ndarray of int, shape (m,)      sample of it
    slips   : ndarray of int, shape (k, 3)    each time a rotor fell to another equilibrium, in order of time: which, at
                                              which sample, how many electrical cycles back
    """

    largest: np.ndarray
    at: np.ndarray
    slips: np.ndarray


def rotor_of(motor: Motor) -> Rotor:
    """The motor's rotor at its run current."""
    stiffness = 0.25 * motor.full_steps * standstill_torque(motor)
    return Rotor(sqrt(stiffness / motor.rotor_inertia), motor.damping)


def equilibrium(u: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Load angle under a load that does not change [rad, electrical]; a right angle where it is too much."""
    return np.arcsin(np.clip(u / g, -1.0, 1.0))


def swings(rotor: Rotor, courses: Sequence[Course], dt: float, stride: float = STRIDE) -> Swings:
    """Integrate the rotor along each course, from the equilibrium at its first sample."""
    m = len(courses)
    largest, at = np.zeros(m), np.zeros(m, np.int64)
    cycles, slips = np.zeros(m, np.int64), [np.zeros((0, 3), np.int64)]
    for k, (row, phi, _) in enumerate(trace(rotor, courses, dt, stride)):
        size = np.minimum(np.abs(phi), pi)
        more = size > largest[row]
        largest[row[more]], at[row[more]] = size[more], k
        fallen = np.rint(phi / CYCLE).astype(np.int64) - cycles[row]
        if fallen.any():
            off = np.flatnonzero(fallen)
            slips.append(np.column_stack([row[off], np.full(len(off), k), fallen[off]]))
            cycles[row] += fallen
    return Swings(largest, at, np.concatenate(slips))


def trace(
    rotor: Rotor, courses: Sequence[Course], dt: float, stride: float = STRIDE
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """At each sample in turn: which courses still go on, phi [rad] and phi' [rad per sample] of each."""
    lengths = np.array([len(course) for course in courses])
    row = np.argsort(-lengths, kind="stable")
    counts = lengths[row]
    flat = joined([courses[r] for r in row])
    first = np.cumsum(counts) - counts
    phi, slope = equilibrium(flat.u[first], flat.g[first]), np.zeros(len(row))
    yield row, phi, slope
    for k in range(int(counts[0]) - 1):
        m = int(np.searchsorted(-counts, -(k + 1), side="left"))  # rows that have a sample k + 1
        phi, slope = _one_sample(rotor, flat, first[:m] + k, phi[:m], slope[:m], dt, stride)
        yield row[:m], phi, slope


def _one_sample(
    rotor: Rotor, course: Course, i: np.ndarray, phi: np.ndarray, slope: np.ndarray, dt: float, stride: float
) -> tuple[np.ndarray, np.ndarray]:
    """phi and phi' a sample after samples i, by the classical method of Runge and Kutta; time runs in samples."""
    stiffness, drag = (rotor.w * dt) ** 2, 2.0 * rotor.zeta * rotor.w * dt
    u, g, step, ripple = course.u[i], course.g[i], course.step[i], course.ripple[i]
    du, dg, dstep = course.u[i + 1] - u, course.g[i + 1] - g, course.step[i + 1] - step
    rippled = bool(ripple.any())

    def bend(phi: np.ndarray, slope: np.ndarray, t: float) -> np.ndarray:
        if rippled:
            y = step + t * dstep
            phi = phi + ripple * (quantised(y, 1.0) - y)
        return np.asarray(stiffness * (u + t * du - (g + t * dg) * np.sin(phi)) - drag * slope)

    n = max(1, ceil(rotor.w * dt / stride))
    h = 1.0 / n
    for j in range(n):
        a = bend(phi, slope, j * h)
        b = bend(phi + 0.5 * h * slope, slope + 0.5 * h * a, (j + 0.5) * h)
        c = bend(phi + 0.5 * h * (slope + 0.5 * h * a), slope + 0.5 * h * b, (j + 0.5) * h)
        d = bend(phi + h * (slope + 0.5 * h * b), slope + h * c, (j + 1) * h)
        phi = phi + h * (slope + h / 6.0 * (a + b + c))
        slope = slope + h / 6.0 * (a + 2.0 * (b + c) + d)
    return phi, slope
