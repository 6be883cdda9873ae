"""What a print asks of its motors, in figures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

SHOWN = 3  # losses of each motor that people are told of


@dataclass(frozen=True)
class Moment:
    """A line of the file, counted from 1, when it is executed [s], and how fast the motor runs then [mm/s]."""

    line: int
    time: float
    speed: float


@dataclass(frozen=True)
class MotorLoad:
    """One motor.

    name, motor  : as the kinematics call it, and what it is
    microstep_um : a microstep; the command is rounded to half of it [um]
    torque       : at rest with the run current [N m]
    share        : highest torque that the rotor takes, its own swinging included, of what the motor has left at that
                   speed; share_at: where
    angle        : largest load angle [full steps]; integrated, or where nothing was, asin(share); angle_at: where
    angle_um     : how far the rotor is off its command then [um]
    integrated   : share of the print that was integrated in full, in so many windows
    """

    name: str
    motor: str
    microstep_um: float
    torque: float
    share: float
    share_at: Moment
    angle: float
    angle_um: float
    angle_at: Moment
    integrated: float
    windows: int

    @property
    def headroom(self) -> float:
        """Share of the torque that is never wanted; negative where it does not suffice."""
        return 1.0 - self.share


@dataclass(frozen=True)
class LostSteps:
    """Full steps that a motor lost: from a line on, counted from 1, at a time [s]."""

    motor: str
    line: int
    time: float
    steps: int


@dataclass(frozen=True)
class MotorsTold:
    """All motors that a profile describes.

    needed : where more than this share of the torque is taken, the rotor was integrated in full
    """

    motors: tuple[MotorLoad, ...]
    lost: tuple[LostSteps, ...]
    needed: float

    def text(self) -> str:
        """For people, one line."""
        return "; ".join(
            f"{one.name} {100 * one.share:.0f} % of its torque at most (line {one.share_at.line}), "
            f"{one.angle_um:.0f} um behind"
            + (f", {100 * one.integrated:.1g} % of the print integrated" if one.windows else "")
            for one in self.motors
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Where steps are lost: the first losses of each motor, and how many more there are."""
        found = []
        for motor in self.motors:
            lost = [one for one in self.lost if one.motor == motor.name]
            found += [
                f"motor {one.motor} loses {one.steps} full steps at line {one.line} ({one.time:.3f} s)"
                for one in lost[:SHOWN]
            ]
            if len(lost) > SHOWN:
                found.append(f"motor {motor.name} loses steps {len(lost) - SHOWN} times more")
        return tuple(found)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "motors": [{**asdict(motor), "headroom": motor.headroom} for motor in self.motors]}
