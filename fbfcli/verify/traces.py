"""What pictures of a print need, kept in bounded memory while it streams past."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from fbfcli.verify.close_ups import CloseUp, CloseUps
from fbfcli.verify.curves import Curves, Method
from fbfcli.verify.layer_paths import Layer, LayerPaths, Thinning
from fbfcli.verify.passage import Passage

T = TypeVar("T")
POINTS = 300_000  # of all paths: 6 MB of a page
CORNERS = 16  # of the first method, half as many of each other one
TOGETHER = 65_536  # samples that are looked at at once


@dataclass(frozen=True)
class Kept:
    """What was kept of a print: nouns for pictures. The first method is what the others are compared with."""

    methods: dict[str, Method]
    layers: tuple[Layer, ...]
    corners: tuple[CloseUp, ...]
    thinning: Thinning

    def renamed(self, names: Mapping[str, str]) -> Kept:
        """The same with other names of the methods."""

        def under(old: dict[str, T]) -> dict[str, T]:
            return {names.get(name, name): each for name, each in old.items()}

        layers = tuple(replace(layer, nozzle=under(layer.nozzle)) for layer in self.layers)
        corners = tuple(
            replace(corner, method=names.get(corner.method, corner.method), windows=under(corner.windows))
            for corner in self.corners
        )
        return replace(self, methods=under(self.methods), layers=layers, corners=corners)


class Traces:
    """Collects the passages of one or several methods, one after the other or by turns.

    points  : of all thinned paths together
    corners : of the first method that are kept in full resolution, half as many of each other one

    Where a print has extruded nothing yet, every move draws: plotters and mills never extrude.
    """

    def __init__(self, points: int = POINTS, corners: int = CORNERS):
        self._paths, self._corners = LayerPaths(points), CloseUps(corners)
        self._curves: dict[str, Curves] = {}
        self._extrudes: set[str] = set()
        self._dt = 0.0

    def begin(self, name: str, features: Sequence[str]) -> None:
        """A method begins; what the features are called is told with the figures."""
        self._curves.setdefault(name, Curves())

    def add(self, name: str, passage: Passage) -> None:
        """More of what the machine makes of a method."""
        for first in range(0, len(passage), TOGETHER):
            self._add(name, passage[first : first + TOGETHER])

    def _add(self, name: str, passage: Passage) -> None:
        execution = passage.execution
        curves = self._curves.setdefault(name, Curves())
        first = name == next(iter(self._curves))
        drawn = execution.extruding
        if name not in self._extrudes and drawn.any():
            self._extrudes.add(name)
            self._paths.forget(name, first)
            self._corners.forget(name)
        if name not in self._extrudes:
            drawn = np.ones(len(passage), dtype=bool)
        self._paths.add(name, passage, drawn, first)
        self._corners.add(name, passage, drawn)
        curves.add(passage, drawn)
        self._dt = execution.dt

    def segments(self, name: str, starts: np.ndarray) -> None:
        """More written segments: when each begins, shape (k,), since the print began [s]."""
        self._curves.setdefault(name, Curves()).count(starts)

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        """More of the motors' loads: share (n, m) of the torque that each of m motors has, at time (n,) [s]."""
        self._curves.setdefault(name, Curves()).carry(time, share, tuple(motors))

    def kept(self) -> Kept:
        """What there is to see of all that was added."""
        if self._dt:
            self._corners.finish(self._dt)
        methods = {name: curves.method() for name, curves in self._curves.items()}
        return Kept(methods, self._paths.layers(), self._corners.corners(), self._paths.thinning())
