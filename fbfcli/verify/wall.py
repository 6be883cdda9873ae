"""The surface that a straight wall will have: how far the nozzle is beside its path, mm by mm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify.heading import Heading
from fbfcli.verify.held_back import Rows
from fbfcli.verify.passage import Passage

OUTER = ("external perimeter", "outer wall", "wall-outer", "outer perimeter", "shell-outer")  # what is seen of a part
PERIMETER = ("perimeter", "loop", "inner wall", "wall-inner", "inner perimeter", "shell-inner")  # or nearly so
STEP = 0.05  # mm: points of a profile
SAME = 2.0  # mm: ends of a line that another method samples at other points of it
BEND = 1e-3  # rad: directions of one straight line differ by no more
SAMPLING_LENGTHS = 5  # in which Rz is taken
LONGEST_S = 20.0  # of one line; a longer one is looked at as far as that


@dataclass(frozen=True)
class Wall:
    """A straight line that was printed, m points STEP apart.

    axis                 : 0, 1: X or Y swings across it most
    line, layer, feature : where it begins
    time                 : [s]
    begin, end           : ndarray, shape (2,)   [mm]
    along                : ndarray, shape (m,)   from where it begins [mm]
    off                  : ndarray, shape (m,)   nozzle beside the path, to the left positive [mm]
    """

    axis: int
    line: int
    layer: int
    feature: int
    time: float
    begin: np.ndarray
    end: np.ndarray
    along: np.ndarray
    off: np.ndarray

    @property
    def length(self) -> float:
        return float(np.hypot(*(self.end - self.begin)))

    @property
    def roughness(self) -> dict[str, float]:
        """Ra, Rq, Rz about the mean line [um]; Rz is the mean height of SAMPLING_LENGTHS parts."""
        z = UM_PER_MM * (self.off - np.polyval(np.polyfit(self.along, self.off, 1), self.along))
        parts = np.array_split(z, SAMPLING_LENGTHS)
        return {
            "Ra": float(np.abs(z).mean()),
            "Rq": float(np.sqrt((z * z).mean())),
            "Rz": float(np.mean([part.max() - part.min() for part in parts])),
        }


class Walls:
    """The longest straight wall across X, and that across Y, of a print that comes in pieces.

    features : names of what is printed, as far as they are known; an outer wall is taken before other walls, these
               before anything else
    like     : of another method, ahead of this one or in step with it: the same walls are looked for
    """

    def __init__(self, features: list[str], like: Walls | None = None):
        self._features, self._like = features, like
        self._found: dict[int, Wall] = {}
        self._heading: Heading | None = None
        self._open: Rows | None = None  # the line that goes on

    def add(self, passage: Passage) -> None:
        """Look at more of the print."""
        here = passage.execution
        self._heading = self._heading or Heading(here.dt)
        heading = self._heading.follow(here.desired, here.begin)
        begins = np.zeros(len(here), dtype=bool)
        begins[here.begin] = True
        rows: Rows = (here.desired, passage.across, heading, here.extruding, begins, here.line, here.layer,
                      here.feature, here.time)  # fmt: skip
        if self._open is not None:
            rows = tuple(np.concatenate(pair) for pair in zip(self._open, rows, strict=True))
        starts = _starts(rows[2], rows[3], rows[4])
        self._look(rows, starts, np.append(starts[1:], len(rows[0])))
        keep = max(int(starts[-1]), len(rows[0]) - round(LONGEST_S / here.dt))
        self._open = tuple(row[keep:] for row in rows)

    def found(self) -> tuple[Wall, ...]:
        """The walls across X and across Y, those of them that there are."""
        return tuple(self._found[axis] for axis in sorted(self._found))

    def _look(self, rows: Rows, starts: np.ndarray, ends: np.ndarray) -> None:
        """Keep the best lines, from `starts` to before `ends` (k,)."""
        desired, _, heading, extruding, _, _, _, feature, _ = rows
        length = np.hypot(*(desired[ends - 1] - desired[starts]).T)
        outer = np.array([_seen(name) for name in self._features])[feature[starts]]
        axis = (np.abs(heading[ends - 1, 0]) > np.abs(heading[ends - 1, 1])).astype(np.int64)
        fit = extruding[starts] & (length > 2 * SAMPLING_LENGTHS * STEP)
        if self._like is not None:
            self._look_for(self._like.found(), rows, starts[fit], ends[fit])
            return
        for each in (0, 1):
            of = np.flatnonzero(fit & (axis == each))
            if not len(of):
                continue
            best = int(of[np.lexsort((-starts[of], np.round(length[of], 3), outer[of]))[-1]])
            had = self._found.get(each)
            if had is None or (outer[best], length[best] - STEP) > (_seen(self._features[had.feature]), had.length):
                self._found[each] = _wall(rows, each, int(starts[best]), int(ends[best]))

    def _look_for(self, walls: tuple[Wall, ...], rows: Rows, starts: np.ndarray, ends: np.ndarray) -> None:
        """Keep those of the lines that are these walls."""
        desired, line = rows[0], rows[5]
        for wall in walls:
            near = np.hypot(*(desired[starts] - wall.begin).T) + np.hypot(*(desired[ends - 1] - wall.end).T) < SAME
            same = np.flatnonzero(near & (np.abs(line[starts] - wall.line) <= 1))
            if len(same):
                self._found[wall.axis] = _wall(rows, wall.axis, int(starts[same[0]]), int(ends[same[0]]))


def is_outer(feature: str) -> bool:
    """Whether a slicer calls the feature an outer wall."""
    return feature.lower() in OUTER


def _seen(feature: str) -> int:
    """How much of the surface a feature is: the more, the rather it is shown."""
    return 2 * is_outer(feature) + (feature.lower() in PERIMETER)


def _starts(heading: np.ndarray, extruding: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """Samples at which a line begins; the first is 0."""
    new = begins.copy()
    new[1:] |= extruding[1:] != extruding[:-1]
    turned = np.abs(heading[1:, 0] * heading[:-1, 1] - heading[1:, 1] * heading[:-1, 0]) > BEND
    new[1:] |= turned | ((heading[1:] * heading[:-1]).sum(axis=1) < 0.0)
    new[0] = True
    return np.flatnonzero(new)


def _wall(rows: Rows, axis: int, a: int, b: int) -> Wall:
    desired, across, _, _, _, line, layer, feature, time = (row[a:b] for row in rows)
    way = np.cumsum(np.hypot(*np.diff(desired, axis=0, prepend=desired[:1]).T))
    along = np.arange(0.0, way[-1], STEP)
    return Wall(axis, int(line[0]), int(layer[0]), int(feature[0]), float(time[0]), desired[0].copy(),
                desired[-1].copy(), along, np.interp(along, way, across))  # fmt: skip
