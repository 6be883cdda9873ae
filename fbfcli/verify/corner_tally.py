"""Corners of a print counted as they come: how large, how often, and which were the worst."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify.log_bins import LogBins
from fbfcli.verify.ringing import Corner

WORST = 20  # corners that are told of
KINDS = ("rounding", "overshoot", "amplitude", "wavelength")


@dataclass(frozen=True)
class Spread:
    """Median, 99th percentile, maximum."""

    median: float
    p99: float
    max: float


@dataclass(frozen=True)
class CornerFigures:
    """Of `count` corners, `rings` of which ring: wavelength [mm], the others [um]."""

    count: int
    rings: int
    rounding: Spread
    overshoot: Spread
    amplitude: Spread
    wavelength: Spread


@dataclass(frozen=True)
class WorstCorner:
    """A corner, for people: line counted from 1, time [s], position, wavelength [mm], turn [deg], the others [um].

    wavelength, frequency : None where nothing rings
    """

    line: int
    layer: int
    feature: str
    axis: str
    time: float
    x: float
    y: float
    turn: float
    rounding: float
    overshoot: float
    amplitude: float
    wavelength: float | None
    frequency: float | None


class CornerTally:
    """Corners so far. `features`: names, as far as they are known."""

    def __init__(self, features: list[str]):
        self._features = features
        self._axes, self._by_feature = ([LogBins() for _ in KINDS] for _ in range(2))
        self._worst: list[WorstCorner] = []

    def add(self, found: Corner) -> None:
        """Count more corners."""
        for axes, by_feature, kind in zip(self._axes, self._by_feature, KINDS, strict=True):
            value = getattr(found, kind)
            there = np.isfinite(value)
            for bins, group in ((axes, found.axis), (by_feature, found.feature)):
                bins.add(group[there], value[there])
        size = np.maximum(found.amplitude, found.overshoot)
        most = np.argsort(-size, kind="stable")[:WORST]
        self._worst += [self._told(found, k) for k in most.tolist()]
        self._worst.sort(key=lambda corner: -max(corner.amplitude, corner.overshoot))
        del self._worst[WORST:]

    @property
    def total(self) -> CornerFigures:
        """Of all."""
        return _figures([bins.all() for bins in self._axes], 0)

    @property
    def by(self) -> dict[str, CornerFigures]:
        """By the axis that swings, "x" and "y", and by feature, those that have corners."""
        told = {"xy"[k]: _figures(self._axes, k) for k in np.flatnonzero(self._axes[0].count).tolist()}
        here = np.flatnonzero(self._by_feature[0].count).tolist()
        return told | {self._features[k]: _figures(self._by_feature, k) for k in here}

    @property
    def worst(self) -> tuple[WorstCorner, ...]:
        """Those that ring most or overshoot most, the worst first."""
        return tuple(self._worst)

    def _told(self, found: Corner, k: int) -> WorstCorner:
        x, y = found.point[k].tolist()
        return WorstCorner(
            line=int(found.line[k]) + 1,
            layer=int(found.layer[k]),
            feature=self._features[int(found.feature[k])],
            axis="xy"[int(found.axis[k])],
            time=float(found.time[k]),
            x=x,
            y=y,
            turn=float(np.degrees(found.turn[k])),
            rounding=UM_PER_MM * float(found.rounding[k]),
            overshoot=UM_PER_MM * float(found.overshoot[k]),
            amplitude=UM_PER_MM * float(found.amplitude[k]),
            wavelength=_known(found.wavelength[k]),
            frequency=_known(found.frequency[k]),
        )


def _known(value: np.floating) -> float | None:
    return float(value) if np.isfinite(value) else None


def _figures(kinds: list[LogBins], k: int) -> CornerFigures:
    """Of group k of bins of each of KINDS."""
    units = (UM_PER_MM, UM_PER_MM, UM_PER_MM, 1.0)
    spreads = [_spread(bins, k, unit) for bins, unit in zip(kinds, units, strict=True)]
    count, rings = (int(bins.count[k]) if k < len(bins.count) else 0 for bins in (kinds[0], kinds[3]))
    return CornerFigures(count, rings, *spreads)


def _spread(bins: LogBins, k: int, unit: float) -> Spread:
    rows = (bins.quantile(0.5), bins.quantile(0.99), bins.max)
    return Spread(*(unit * float(row[k]) if k < len(row) else 0.0 for row in rows))
