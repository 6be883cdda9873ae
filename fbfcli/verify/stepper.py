"""The steppers under a print: how much of their torque it takes, how far their rotors are behind, where steps are lost.

For every sample there is what a linear rotor takes (`rotor_bound`). Where that is more than NEEDED of the torque that
is left, the rotor is integrated in full (`rotor`), until the motor runs slowly enough to catch a rotor that was lost.
What stays below NEEDED is far from the maximum of the sine, where a rotor falls off.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

from fbfcli.motion.kinematics import kinematics_of
from fbfcli.printer import Motor, Printer
from fbfcli.verify.microsteps import finest
from fbfcli.verify.motor_course import Asked, Asking
from fbfcli.verify.motors_told import LostSteps, Moment, MotorLoad, MotorsTold
from fbfcli.verify.passage import Passage
from fbfcli.verify.rotor import STRIDE, Course, rotor_of, swings
from fbfcli.verify.rotor_bound import Bound
from fbfcli.verify.rotor_windows import Windows
from fbfcli.verify.torque_speed import standstill_torque, torque_left

NEEDED = 0.5  # of the torque that is left: what the bound exceeds is integrated
TOGETHER = 300_000  # samples of windows that are integrated at once: rows of arrays
FELT = 0.5  # microsteps in a step of integration beyond which the rotor sees no steps
STEPS_PER_CYCLE = 4
FALL_S = 0.05  # s without a slip after which the next one is another loss


Watch = Callable[[np.ndarray, np.ndarray, tuple[str, ...]], None]


class Motors:
    """All motors of a printer that its profile describes, fed with a print piece by piece. ProfileError: kinematics_of.

    needed : NEEDED; 0 integrates everything
    watch  : told of times (n,) [s], the share of its torque that each of m motors is asked for then, (n, m), and names
    """

    def __init__(self, printer: Printer, dt: float, needed: float = NEEDED,
                 watch: Watch = lambda time, share, names: None):  # fmt: skip
        self._needed, self._watch = needed, watch
        described = {i: axis.motor for i, axis in enumerate(printer.axes) if axis.motor is not None}
        self._each: dict[int, _Motor] = {}
        if described:
            kinematics = kinematics_of(printer)
            self._asking = Asking(kinematics, [axis.load for axis in printer.axes], dt)
            self._each = {i: _Motor(kinematics.names[i], motor, dt, needed) for i, motor in described.items()}

    def add(self, passage: Passage) -> None:
        """More of the print. Raises LimitError beyond a delta's reach."""
        if self._each and len(passage):
            self._take(self._asking.add(passage))

    def figures(self) -> MotorsTold:
        """What the whole print asked of them; nothing can be added after it."""
        if self._each:
            self._take(self._asking.finish())
        for motor in self._each.values():
            motor.finish()
        return MotorsTold(
            tuple(motor.told() for motor in self._each.values()),
            tuple(sorted((lost for motor in self._each.values() for lost in motor.lost), key=lambda lost: lost.time)),
            self._needed,
        )

    def _take(self, asked: Asked | None) -> None:
        if asked is not None and len(asked.time):
            shares = [motor.add(asked, i) for i, motor in self._each.items()]
            self._watch(asked.time, np.column_stack(shares), tuple(motor.name for motor in self._each.values()))


class _Motor:
    """One motor: what it is asked for, bounded, cut into windows, integrated, and told."""

    def __init__(self, name: str, motor: Motor, dt: float, needed: float):
        self.name, self._motor, self._dt, self._needed = name, motor, dt, needed
        self._rotor = rotor_of(motor)
        self._bound, self._windows = Bound(self._rotor, dt), Windows(dt)
        self._per_mm = 2.0 * pi / motor.mm_per_turn  # shaft [rad]
        self._lost_track = False  # the bound has been beyond the torque, and the motor still runs fast
        self._waiting: list[Course] = []
        self._samples = self._integrated = self._count = 0
        self._share = self._angle = (0.0, Moment(0, 0.0, 0.0))
        self.lost: list[LostSteps] = []

    def add(self, asked: Asked, i: int) -> np.ndarray:
        """Share of its torque that each sample asks for."""
        course = self._course(asked, i)
        share = self._bound.add(course.u) / course.g
        self._share = _larger(self._share, share, course)
        self._samples += len(course)
        self._waiting += self._windows.add(course, (share >= self._needed) | self._off_track(share, course.speed))
        if sum(map(len, self._waiting)) >= TOGETHER:
            self._integrate()
        return share

    def finish(self) -> None:
        self._waiting += self._windows.finish()
        self._integrate()

    def told(self) -> MotorLoad:
        motor = self._motor
        angle, where = self._angle
        if not self._integrated:
            angle, where = float(np.arcsin(min(1.0, self._share[0]))), self._share[1]
        full_steps = angle / (2.0 * pi) * STEPS_PER_CYCLE
        return MotorLoad(
            name=self.name,
            motor=motor.name,
            microstep_um=1e3 * motor.mm_per_turn / (motor.full_steps * motor.microsteps),
            torque=standstill_torque(motor),
            share=self._share[0],
            share_at=self._share[1],
            angle=full_steps,
            angle_um=1e3 * full_steps * motor.mm_per_turn / motor.full_steps,
            angle_at=where,
            integrated=self._integrated / self._samples if self._samples else 0.0,
            windows=self._count,
        )

    def _course(self, asked: Asked, i: int) -> Course:
        motor, speed = self._motor, asked.speed[:, i]
        arm = 1e-3 / self._per_mm  # m
        torque = motor.rotor_inertia * asked.acceleration[:, i] * self._per_mm + asked.force[:, i] * arm
        positions = finest(motor)
        per_mm = motor.full_steps * positions / motor.mm_per_turn
        felt = np.abs(speed) * per_mm < FELT * self._rotor.w / STRIDE
        return Course(
            u=torque / standstill_torque(motor),
            g=torque_left(motor, speed * self._per_mm),
            step=asked.q[:, i] * per_mm,
            ripple=np.where(felt, 0.5 * pi / positions, 0.0),
            speed=speed,
            time=asked.time,
            line=asked.line,
        )

    def _off_track(self, share: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """From where the torque may not suffice until the field is slow: below its own frequency a rotor is caught."""
        fast = np.abs(speed) * self._per_mm * self._motor.full_steps / STEPS_PER_CYCLE > self._rotor.w
        k = np.arange(len(share))
        beyond = np.maximum.accumulate(np.where(share >= 1.0, k, -1))
        slow = np.maximum.accumulate(np.where(fast, -1, k))
        off = (beyond > slow) | (self._lost_track & (slow < 0))
        self._lost_track = bool(off[-1])
        return np.asarray(off)

    def _integrate(self) -> None:
        if not self._waiting:
            return
        swung = swings(self._rotor, self._waiting, self._dt)
        for i, course in enumerate(self._waiting):
            if swung.largest[i] > self._angle[0]:
                self._angle = float(swung.largest[i]), _moment(course, int(swung.at[i]))
            for at, cycles in _falls(swung.slips[swung.slips[:, 0] == i, 1:], round(FALL_S / self._dt)):
                where = _moment(course, at)
                self.lost.append(LostSteps(self.name, where.line, where.time, STEPS_PER_CYCLE * abs(cycles)))
        self._integrated += sum(map(len, self._waiting))
        self._count += len(self._waiting)
        self._waiting = []


def _falls(slips: np.ndarray, apart: int) -> list[tuple[int, int]]:
    """First sample and electrical cycles of each loss, from single slips, shape (k, 2); one that is caught is none."""
    cuts = np.flatnonzero(np.diff(slips[:, 0]) > apart) + 1
    groups = [group for group in np.split(slips, cuts) if len(group)]
    return [(int(group[0, 0]), int(group[:, 1].sum())) for group in groups if group[:, 1].sum()]


Found = tuple[float, Moment]


def _larger(found: Found, values: np.ndarray, course: Course) -> Found:
    """The largest value so far, and where it is."""
    i = int(values.argmax())
    return (float(values[i]), _moment(course, i)) if values[i] > found[0] else found


def _moment(course: Course, i: int) -> Moment:
    return Moment(int(course.line[i]) + 1, float(course.time[i]), float(course.speed[i]))
