"""What is told of a simulated print, for people and for scripts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from fbfcli.pipeline.machine import Condition
from fbfcli.pipeline.rows import aligned, told
from fbfcli.pipeline.summary import Summary, clock
from fbfcli.verify.account import Accounted
from fbfcli.verify.motors_told import MotorsTold
from fbfcli.verify.shaper_tuning import MadeFor

NO_MOTOR = "the profile describes no motor: loads and lost steps are not simulated (write [axis.x.motor])"
WORST = 3  # lost steps that are told of one by one


@dataclass(frozen=True)
class Simulated:
    """One print by one method.

    name         : of the method, as it was asked for
    method, why  : the method that was taken, and why where fbf chose or assumed something
    made_for     : of a shaper, on X and Y
    acceleration : it was planned with [mm/s^2]; None: the file's own
    time         : of the print [s]
    figures      : under each condition, in their order
    motors       : as modelled
    compensated  : the summary of the compensation; None where the file was executed as it is written
    """

    name: str
    method: str
    why: str
    made_for: tuple[MadeFor, ...]
    acceleration: float | None
    time: float
    figures: tuple[Accounted, ...]
    motors: MotorsTold
    compensated: Summary | None
    warnings: tuple[str, ...]

    def as_dict(self, conditions: Sequence[Condition], features: Sequence[str]) -> dict[str, object]:
        """For --json."""
        accounts = zip(conditions, self.figures, strict=True)
        return {
            "name": self.name,
            "method": self.method,
            "why": self.why,
            "made_for": [asdict(one) for one in self.made_for],
            "acceleration": self.acceleration,
            "time": self.time,
            "conditions": {condition.name: figures.as_dict(features) for condition, figures in accounts},
            "motors": self.motors.as_dict(),
            "compensated": None if self.compensated is None else self.compensated.as_dict(),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True)
class Simulation:
    """A file simulated: `rate` samples a second of what `machine` draws with text that is meant for `printer`.

    features : names of what is printed, by number
    layers   : how many, 0 where nothing tells them
    left_out : methods that cannot work on the printer's model, and why
    """

    printer: str
    machine: str
    rate: float
    features: tuple[str, ...]
    layers: int
    conditions: tuple[Condition, ...]
    results: tuple[Simulated, ...]
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        return {
            "printer": self.printer,
            "machine": self.machine,
            "rate": self.rate,
            "features": list(self.features),
            "layers": self.layers,
            "conditions": [asdict(condition) for condition in self.conditions],
            "results": [one.as_dict(self.conditions, self.features) for one in self.results],
            "warnings": list(self.warnings),
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of all results, each once."""
        names: dict[str, dict[str, None]] = {}
        for one in self.results:
            for warning in one.warnings:
                names.setdefault(warning, {})[one.name] = None
        many = len({one.name for one in self.results})
        each = [warning if len(by) == many else f"{', '.join(by)}: {warning}" for warning, by in names.items()]
        lost = [warning for one in self.results for warning in _lost(one)]
        return tuple(dict.fromkeys([*self.left_out, *each, *lost]))

    def text(self) -> str:
        """For people, on stderr."""
        rows = [("machine", f"{self.machine}, sampled {self.rate:.0f} times a second")]
        rows += [(one.name, words) for one in self.results if (words := self._choice(one))]
        parts = [self._errors()]
        if len(self.conditions) > 1:
            parts.append(self._mismatch())
        if motors := self.results[0].motors.motors:
            head = ("torque at most, rotor behind by", *(f"motor {motor.name}" for motor in motors), "lost steps")
            parts.append(aligned([head, *((self._name(one), *_loads(one.motors)) for one in self.results)]))
            rows += [(f"motors, {one.name}", one.motors.choice) for one in self.results if one.motors.integrated]
        else:
            rows.append(("motors", NO_MOTOR))
        return "\n\n".join([*parts, told(rows, self.warnings)])

    def _errors(self) -> str:
        """The table of the methods, as modelled."""
        head = ("errors in um", "print time", "contour rms", "99 %", "max", "tracking rms", "ringing 99 %", "bead rms")
        rows = [
            (
                self._name(one),
                clock(one.time),
                f"{error.contour.rms:.1f}",
                f"{error.contour.p99:.0f}",
                f"{error.contour.max:.0f}",
                f"{error.tracking.rms:.1f}",
                f"{one.figures[0].corners.amplitude.p99:.0f}",
                f"{100 * one.figures[0].bead.rms:.1f} %",
            )
            for one in self.results
            for error in [one.figures[0].drawn]
        ]
        return aligned([head, *rows])

    def _mismatch(self) -> str:
        """Contour errors of the methods under every condition."""
        rows = [
            (self._name(one), *(f"{figures.drawn.contour.rms:.1f}" for figures in one.figures)) for one in self.results
        ]
        return aligned([("contour rms in um", *(condition.name for condition in self.conditions)), *rows])

    def _name(self, one: Simulated) -> str:
        several = len({each.acceleration for each in self.results}) > 1
        return f"{one.name}, {one.acceleration:g} mm/s^2" if several else one.name

    def _choice(self, one: Simulated) -> str:
        """What was taken, where that needs to be said."""
        if one.acceleration != self.results[0].acceleration:
            return ""
        made = ", ".join(f"{axis} {made.frequency:.1f} Hz" for axis, made in zip("xy", one.made_for, strict=False))
        method = one.method if one.name == "auto" else ""
        return "; ".join(filter(None, (method, one.why, f"made for {made}" if made else "")))


def _loads(told: MotorsTold) -> list[str]:
    """How hard each motor works, how far its rotor is behind, and the steps that all of them lose."""
    lost = sum(each.steps for each in told.lost)
    return [*(f"{100 * motor.share:.0f} %, {motor.angle_um:.0f} um" for motor in told.motors), f"{lost}"]


def _lost(one: Simulated) -> list[str]:
    """The first steps that motors lose."""
    lost = one.motors.lost
    told = [
        f"{one.name}: motor {each.motor} loses {each.steps} steps at line {each.line} ({each.time:.3f} s)"
        for each in lost[:WORST]
    ]
    return [*told, *([f"{one.name}: steps are lost {len(lost)} times in all"] if len(lost) > WORST else [])]
