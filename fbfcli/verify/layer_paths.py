"""The paths of a print's layers for a plan view: thinned as they come, and thinned further when they grow too many.

Points fall out first until TOLERANCES[-1] is reached, then layers: every second, every fourth, ... is kept, and the
same ones of all methods. A print with one layer left is thinned on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbfcli.verify.execution import Execution
from fbfcli.verify.passage import Passage
from fbfcli.verify.thinning import thinned

TOLERANCES = (2e-3, 16e-3)  # mm: a point that stays away moves the drawn line, and its error, by no more


@dataclass(frozen=True)
class Path:
    """One thinned path of a layer; k points, all of them samples of the print.

    x     : ndarray, shape (k, 2)          X Y [mm]
    error : ndarray, shape (k,)            distance from the desired path [mm]; of that itself, 0
    line  : ndarray of int, shape (k,)     line of the file that asks for it, counted from 0
    new   : ndarray of bool, shape (k,)    a run begins here: no line leads to it
    """

    x: np.ndarray
    error: np.ndarray
    line: np.ndarray
    new: np.ndarray

    def __len__(self) -> int:
        return len(self.error)

    def __getitem__(self, rows: np.ndarray) -> Path:
        return Path(self.x[rows], self.error[rows], self.line[rows], self.new[rows])

    def thinned(self, tolerance: float) -> Path:
        """The same with fewer points: runs keep their ends, the path its largest error."""
        ends = np.flatnonzero(self.new)
        worst = np.argmax(self.error, keepdims=True)
        seeds = np.unique(np.concatenate([ends, ends - 1, worst]))
        return self[thinned(np.column_stack([self.x, self.error]), seeds[seeds >= 0], tolerance)]


@dataclass(frozen=True)
class Layer:
    """What there is to see of a layer.

    number  : counted from 0
    z       : height [mm]
    desired : Path
    nozzle  : of each method, in their order
    """

    number: int
    z: float
    desired: Path
    nozzle: dict[str, Path]


@dataclass(frozen=True)
class Thinning:
    """What was left out: `kept` of `samples` samples, every `stride`-th of `layers` layers, within `tolerance` [mm]."""

    kept: int
    samples: int
    stride: int
    layers: int
    tolerance: float


class LayerPaths:
    """Collects the paths of all methods in no more than `budget` points."""

    def __init__(self, budget: int):
        self._budget = budget
        self._paths: dict[int, dict[str, Path]] = {}  # by layer, then by method; "" is the desired path
        self._z: dict[int, float] = {}
        self._ends: dict[str, tuple[int, bool]] = {}  # of each method: layer and presence of the last sample
        self._count = self._samples = 0
        self._stride, self._tolerance = 1, TOLERANCES[0]

    def add(self, name: str, passage: Passage, drawn: np.ndarray, with_desired: bool) -> None:
        """More of a method's nozzle where something is `drawn`, bool, (n,); `with_desired`: and of the desired path."""
        execution = passage.execution
        self._samples += int(drawn.sum())
        new = self._new(name, execution, drawn)
        self._ends[name] = int(execution.layer[-1]), bool(drawn[-1])
        for layer in np.unique(execution.layer[drawn]).tolist():
            rows = np.flatnonzero(drawn & (execution.layer == layer))
            self._z.setdefault(layer, float(execution.motion[rows[0], 2]))
            if layer % self._stride == 0:
                self._put(layer, name, Path(passage.nozzle[rows], passage.contour[rows], execution.line[rows],
                                            new[rows]))  # fmt: skip
                if with_desired:
                    self._put(layer, "", Path(execution.desired[rows], np.zeros(len(rows)), execution.line[rows],
                                              new[rows]))  # fmt: skip
        while self._count > self._budget:
            self._coarsen()

    def layers(self) -> tuple[Layer, ...]:
        """Those that are kept, from the lowest number."""
        none = Path(np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool))
        return tuple(
            Layer(number, self._z[number], paths.get("", none), {name: path for name, path in paths.items() if name})
            for number, paths in sorted(self._paths.items())
        )

    def thinning(self) -> Thinning:
        """What was left out so far."""
        kept = sum(len(path) for paths in self._paths.values() for name, path in paths.items() if name)
        return Thinning(kept, self._samples, self._stride, len(self._z), self._tolerance)

    def _new(self, name: str, execution: Execution, drawn: np.ndarray) -> np.ndarray:
        """Samples at which a run begins: after a rest, a gap, or in another layer than the sample before."""
        layer, present = self._ends.get(name, (-1, False))
        before = np.concatenate([[present], drawn[:-1]])
        new = ~before | (np.diff(execution.layer, prepend=layer) != 0)
        new[execution.begin] = True
        return new

    def _put(self, layer: int, name: str, path: Path) -> None:
        more = path.thinned(self._tolerance)
        self._count += len(more)
        paths = self._paths.setdefault(layer, {})
        known = paths.get(name)
        paths[name] = more if known is None else Path(
            np.concatenate([known.x, more.x]), np.concatenate([known.error, more.error]),
            np.concatenate([known.line, more.line]), np.concatenate([known.new, more.new]),
        )  # fmt: skip

    def _coarsen(self) -> None:
        if self._tolerance < TOLERANCES[1] or len(self._paths) < 2:
            self._tolerance *= 2
            self._paths = _each(self._paths, lambda path: path.thinned(self._tolerance))
        else:
            self._stride *= 2
            self._paths = {layer: paths for layer, paths in self._paths.items() if layer % self._stride == 0}
        self._recount()

    def forget(self, name: str, with_desired: bool) -> None:
        """What was drawn by a method so far is no part of the print."""
        gone = {name, ""} if with_desired else {name}
        self._paths = {
            layer: left
            for layer, paths in self._paths.items()
            if (left := {each: path for each, path in paths.items() if each not in gone})
        }
        self._ends.pop(name, None)
        self._z = {layer: z for layer, z in self._z.items() if layer in self._paths}
        self._recount()

    def _recount(self) -> None:
        self._count = sum(len(path) for paths in self._paths.values() for path in paths.values())


def _each(paths: dict[int, dict[str, Path]], change: Callable[[Path], Path]) -> dict[int, dict[str, Path]]:
    return {layer: {name: change(path) for name, path in of.items()} for layer, of in paths.items()}
