"""What is told of a simulated print, for people and for scripts."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from fbfcli.pipeline.machine import Condition
from fbfcli.pipeline.summary import Summary, clock, told
from fbfcli.verify.account import Accounted


@dataclass(frozen=True)
class Simulated:
    """One print by one method.

    name         : of the method, as it was asked for
    method, why  : the method that was taken, and why where fbf chose or assumed something
    acceleration : it was planned with [mm/s^2]; None: the file's own
    time         : of the print [s]
    figures      : of each condition, in their order
    compensated  : the summary of the compensation; None where the file was executed as it is written
    """

    name: str
    method: str
    why: str
    acceleration: float | None
    time: float
    figures: tuple[Accounted, ...]
    compensated: Summary | None
    warnings: tuple[str, ...]

    def as_dict(self, conditions: tuple[Condition, ...]) -> dict[str, object]:
        """For --json."""
        return {
            "name": self.name,
            "method": self.method,
            "why": self.why,
            "acceleration": self.acceleration,
            "time": self.time,
            "conditions": {
                condition.name: figures.as_dict() for condition, figures in zip(conditions, self.figures, strict=True)
            },
            "compensated": None if self.compensated is None else self.compensated.as_dict(),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True)
class Simulation:
    """A file simulated: `rate` samples a second of what `machine` draws with text that is meant for `printer`."""

    printer: str
    machine: str
    rate: float
    conditions: tuple[Condition, ...]
    results: tuple[Simulated, ...]
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        return {
            "printer": self.printer,
            "machine": self.machine,
            "rate": self.rate,
            "conditions": [asdict(condition) for condition in self.conditions],
            "results": [one.as_dict(self.conditions) for one in self.results],
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """For people, on stderr."""
        rows = [
            (
                one.name,
                f"{clock(one.time)}; contour error {one.figures[0].contour['rms']:.1f} um rms, "
                f"{one.figures[0].contour['p99']:.0f} um 99 %, {one.figures[0].contour['max']:.0f} um max",
            )
            for one in self.results
        ]
        return told(rows, self.warnings)
