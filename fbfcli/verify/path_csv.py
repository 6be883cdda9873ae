"""Where the nozzle goes, sample by sample, as rows of comma-separated values."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify.passage import Passage

COLUMNS = (
    "method,time,line,layer,feature,extruding,desired_x,desired_y,executed_x,executed_y,nozzle_x,nozzle_y,"
    "tracking_um,contour_um"
)
ROW = "%s,%.6f,%d,%d,%s,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.3f,%.3f\n"


class PathCsv:
    """Watches a simulation, and writes a row for every sample of motion: s, mm, lines counted from 1.

    write : takes the text
    """

    def __init__(self, write: Callable[[bytes], object]):
        self._write = write
        self._features: Sequence[str] = ()
        write(f"{COLUMNS}\n".encode())

    def begin(self, name: str, features: Sequence[str]) -> None:
        """A method begins."""
        self._features = features

    def add(self, name: str, passage: Passage) -> None:
        """More of what the machine makes of it."""
        here = passage.execution
        names = np.array([_quoted(feature) for feature in self._features])
        columns = (
            [name] * len(passage),
            here.time.tolist(),
            (here.line + 1).tolist(),
            here.layer.tolist(),
            names[here.feature].tolist(),
            here.extruding.tolist(),
            *(column.tolist() for path in (here.desired, here.motion[:, :2], passage.nozzle) for column in path.T),
            (UM_PER_MM * passage.tracking).tolist(),
            (UM_PER_MM * passage.contour).tolist(),
        )
        self._write("".join(map(ROW.__mod__, zip(*columns, strict=True))).encode())

    def segments(self, name: str, starts: np.ndarray) -> None:
        """Not written."""

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        """Not written."""


def _quoted(word: str) -> str:
    """A name as one cell."""
    return '"' + word.replace('"', '""') + '"' if any(mark in word for mark in ',"') else word
