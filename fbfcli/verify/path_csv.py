"""Where the nozzle goes, sample by sample, as rows of comma-separated values."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fbfcli.digits import Cell, chosen, decimal, fixed, rows
from fbfcli.units import UM_PER_MM
from fbfcli.verify.passage import Passage

COLUMNS = (
    "method,time,line,layer,feature,extruding,desired_x,desired_y,executed_x,executed_y,nozzle_x,nozzle_y,"
    "tracking_um,contour_um"
)
PLACES, PLACES_UM = 6, 3  # decimals of s and mm, and of um


class PathCsv:
    """Watches a simulation, and writes a row for every sample of motion: s, mm, lines counted from 1.

    write : takes the text
    """

    def __init__(self, write: Callable[[bytes], object]):
        self._write = write
        self._features: Sequence[str] = ()  # grows while the file is read
        write(f"{COLUMNS}\n".encode())

    def begin(self, name: str, features: Sequence[str]) -> None:
        """A method begins."""
        self._features = features

    def add(self, name: str, passage: Passage) -> None:
        """More of what the machine makes of it."""
        here = passage.execution
        names = [_quoted(feature).encode() for feature in self._features]
        told = [
            decimal(here.line + 1), decimal(here.layer), chosen(names, here.feature), decimal(here.extruding * 1),
            *(_rounded(each, PLACES) for path in (here.desired, here.motion[:, :2], passage.nozzle) for each in path.T),
            *(_rounded(UM_PER_MM * each, PLACES_UM) for each in (passage.tracking, passage.contour)),
        ]  # fmt: skip
        behind = [cell for each in told for cell in (fixed(b","), each)]
        first = fixed(f"{name},".encode())
        self._write(rows(len(passage), first, _rounded(here.time, PLACES), *behind, fixed(b"\n")))

    def segments(self, name: str, starts: np.ndarray) -> None:
        """Not written."""

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        """Not written."""


def _rounded(value: np.ndarray, places: int) -> Cell:
    return decimal(np.rint(value * 10**places).astype(np.int64), places)


def _quoted(word: str) -> str:
    """A name as one cell."""
    return '"' + word.replace('"', '""') + '"' if any(mark in word for mark in ',"') else word
