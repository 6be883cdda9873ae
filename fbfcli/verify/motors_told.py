"""What a print asks of its motors, in figures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


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

    @property
    def integrated(self) -> float:
        """Share of the print that was integrated in full, of the motor that has most."""
        return max((motor.integrated for motor in self.motors), default=0.0)

    @property
    def choice(self) -> str:
        """What was integrated, for people."""
        return (
            f"rotors are integrated where they take more than {100 * self.needed:g} % of their torque: "
            f"{100 * self.integrated:.2g} % of the time"
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "motors": [{**asdict(motor), "headroom": motor.headroom} for motor in self.motors]}
