"""The formats of a step stream by name, and who writes them; a NumPy archive needs files (`cli.npz_archive`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from fbfcli.printer import Driver
from fbfcli.steps.compact import CompactWriter
from fbfcli.steps.csv_steps import CsvWriter
from fbfcli.steps.pages import PagesWriter
from fbfcli.steps.positions import PositionsWriter
from fbfcli.steps.stream import Motors, Piece
from fbfcli.steps.vcd import VcdWriter


class Writer(Protocol):
    """Turns a stream into bytes, piece by piece."""

    def head(self) -> Iterator[bytes]:
        """What comes before the first piece."""
        ...

    def add(self, piece: Piece) -> Iterator[bytes]:
        """What is final with one more piece."""
        ...

    def end(self) -> Iterator[bytes]:
        """What comes after the last one."""
        ...


@dataclass(frozen=True)
class Wanted:
    """What a stream is written for.

    motors, driver : of the printer
    dt    : period of the trajectory [s]
    rate  : lines (positions) or ticks (marlin) per second; None: the format's own
    """

    motors: Motors
    driver: Driver
    dt: float
    rate: float | None


PAGE_TICKS = 56_000  # per second: 8,000 segments and 16 kB, which a line of 250,000 baud carries


def _positions(wanted: Wanted) -> Writer:
    return PositionsWriter(wanted.motors, wanted.rate or 1.0 / wanted.dt, wanted.dt)


def _pages(wanted: Wanted) -> Writer:
    return PagesWriter(wanted.motors, round(wanted.rate or PAGE_TICKS))


WRITERS: dict[str, Callable[[Wanted], Writer]] = {
    "csv": lambda wanted: CsvWriter(wanted.motors),
    "compact": lambda wanted: CompactWriter(wanted.motors),
    "vcd": lambda wanted: VcdWriter(wanted.motors, wanted.driver),
    "positions": _positions,
    "marlin": _pages,
}
