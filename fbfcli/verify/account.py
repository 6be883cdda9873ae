"""Placeholder."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from fbfcli.verify.contour_error import ErrorTally
from fbfcli.verify.passage import Passage


@dataclass(frozen=True)
class Accounted:
    tracking: dict[str, float]
    contour: dict[str, float]

    def as_dict(self) -> dict[str, object]:
        return asdict(self)


class Account:
    def __init__(self) -> None:
        self._tracking, self._contour = ErrorTally(), ErrorTally()

    def add(self, passage: Passage) -> None:
        on = passage.execution.extruding
        self._tracking.add(passage.tracking[on])
        self._contour.add(passage.contour[on])

    def figures(self) -> Accounted:
        return Accounted(self._tracking.figures(), self._contour.figures())
