"""Figures of a simulated print: errors in all, layer by layer and feature by feature, its corners, walls and beads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify.bead import BeadFigures, Beads, BeadTally
from fbfcli.verify.contour_error import Errors, ErrorTally
from fbfcli.verify.corner_tally import CornerFigures, CornerTally, WorstCorner
from fbfcli.verify.log_bins import LogBins
from fbfcli.verify.passage import Passage
from fbfcli.verify.ringing import Corner, Ringing
from fbfcli.verify.wall import Wall, Walls

KINDS = ("tracking", "contour", "along")


@dataclass(frozen=True)
class Three:
    """Distance from where the nozzle should be now, from the path, and along the path [um]."""

    tracking: Errors
    contour: Errors
    along: Errors


@dataclass(frozen=True)
class Accounted:
    """Figures of one print on one machine.

    extruding, travel    : seconds of motion of each [s]
    total                : errors while extruding; `off` those of travel
    by_layer, by_feature : while extruding; by number, those that print
    corners, corners_by  : of all corners, and by axis ("x", "y": what swings) and feature
    worst                : corners that ring most, the worst first
    bead, bead_by_feature
    walls                : the longest straight walls
    """

    extruding: float
    travel: float
    total: Three
    off: Three
    by_layer: dict[int, Three]
    by_feature: dict[int, Three]
    corners: CornerFigures
    corners_by: dict[str, CornerFigures]
    worst: tuple[WorstCorner, ...]
    bead: BeadFigures
    bead_by_feature: dict[int, BeadFigures]
    walls: tuple[Wall, ...]

    @property
    def drawn(self) -> Three:
        """Errors of what the print draws: of a file that never extrudes, of all its motion."""
        return self.total if self.extruding else self.off

    def as_dict(self, features: Sequence[str]) -> dict[str, Any]:
        """Everything but the profiles of walls, for JSON; features by name."""
        told = {each.name: getattr(self, each.name) for each in fields(self)}
        told["walls"] = [
            {"axis": "xy"[wall.axis], "line": wall.line + 1, "layer": wall.layer, "feature": features[wall.feature],
             "time": wall.time, "length": wall.length, **wall.roughness} for wall in self.walls
        ]  # fmt: skip
        for name in ("total", "off", "corners", "bead"):
            told[name] = asdict(told[name])
        told["worst"] = [asdict(each) for each in self.worst]
        told["by_layer"] = {str(k): asdict(each) for k, each in self.by_layer.items()}
        told["corners_by"] = {name: asdict(each) for name, each in self.corners_by.items()}
        for name in ("by_feature", "bead_by_feature"):
            told[name] = {features[k]: asdict(each) for k, each in told[name].items()}
        return told


class Account:
    """What is counted of a print while its passages stream past.

    features : names of what is printed, as far as they are known: it may grow while the print is read
    like     : of another method, ahead of this one or in step with it: the same walls are shown
    """

    def __init__(self, features: list[str], like: Account | None = None):
        self._features = features
        self._dt = 0.0
        self._samples = [0, 0]  # of travel, of extruding
        self._total, self._off = ([ErrorTally() for _ in KINDS] for _ in range(2))
        self._layers, self._by_feature = ([LogBins() for _ in KINDS] for _ in range(2))
        self._beads: Beads | None = None
        self._bead_tally = BeadTally()
        self._ringing, self._corners = Ringing(), CornerTally(features)
        self._walls: Walls = Walls(features, like._walls if like else None)

    def add(self, passage: Passage | None) -> tuple[Corner, ...]:
        """Count a passage; the corners that are final with it."""
        if passage is None:
            return ()
        here = passage.execution
        self._dt = here.dt
        self._count(passage)
        self._beads = self._beads or Beads(here.dt)
        pushed = here.motion[:, 3]
        sliced = pushed if here.filament is None else here.filament
        rows = (here.desired, passage.nozzle, pushed, sliced, here.extruding)
        widths = self._beads.add(*rows, here.begin)
        self._bead_tally.add(widths, here.feature[widths.at])
        self._walls.add(passage)
        return self._cornered(self._ringing.add(passage))

    def finish(self) -> tuple[Corner, ...]:
        """The last corners; no more will come."""
        return self._cornered(self._ringing.finish())

    def figures(self) -> Accounted:
        """What has been counted."""
        bead, beads = self._bead_tally.figures()
        travel, extruding = (self._dt * many for many in self._samples)
        return Accounted(
            extruding=extruding,
            travel=travel,
            total=_three(self._total),
            off=_three(self._off),
            by_layer=_by_group(self._layers),
            by_feature=_by_group(self._by_feature),
            corners=self._corners.total,
            corners_by=self._corners.by,
            worst=self._corners.worst,
            bead=bead,
            bead_by_feature=beads,
            walls=self._walls.found(),
        )

    def _count(self, passage: Passage) -> None:
        here = passage.execution
        prints = here.extruding
        many = int(np.count_nonzero(prints))
        self._samples[0] += len(passage) - many
        self._samples[1] += many
        layer, feature = here.layer[prints], here.feature[prints]
        for i, kind in enumerate(KINDS):
            error = np.abs(getattr(passage, kind))
            self._off[i].add(error[~prints])
            error = error[prints]
            self._total[i].add(error)
            self._layers[i].add(layer, error)
            self._by_feature[i].add(feature, error)

    def _cornered(self, found: Corner | None) -> tuple[Corner, ...]:
        if found is None:
            return ()
        self._corners.add(found)
        return (found,)


def _three(tallies: list[ErrorTally]) -> Three:
    return Three(*(Errors(**tally.figures()) for tally in tallies))


def _by_group(kinds: list[LogBins]) -> dict[int, Three]:
    columns = [np.stack([bins.rms, bins.quantile(0.99), bins.max], axis=1) * UM_PER_MM for bins in kinds]
    printed = np.flatnonzero(kinds[0].count)
    return {k: Three(*(Errors(*column[k].tolist()) for column in columns)) for k in printed.tolist()}
