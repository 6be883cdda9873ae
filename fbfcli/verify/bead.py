"""What the extruder lays down against where the nozzle goes: how much wider or thinner a bead is than sliced."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.verify.heading import moving

BEAD = 0.4  # mm: no bead's width changes over less than a nozzle's


@dataclass(frozen=True)
class Widths:
    """Pieces of a bead, k of them, each BEAD long.

    width : ndarray, shape (k,)          of the sliced one: E per mm of the nozzle's way over E per mm of path
    way   : ndarray, shape (k,)          of the path [mm]
    at    : ndarray of int, shape (k,)   the sample after it, of those given last
    """

    width: np.ndarray
    way: np.ndarray
    at: np.ndarray

    @property
    def rms(self) -> float:
        """Deviation from the sliced width, mm by mm."""
        return float(np.sqrt(np.average((self.width - 1.0) ** 2, weights=self.way))) if len(self.way) else 0.0


@dataclass(frozen=True)
class BeadFigures:
    """How far a bead's width is from the sliced one; shares of its length.

    length          : that was measured [mm]
    rms             : deviation, 1 is the whole width
    over_5, over_10 : wider by more than 5 %, 10 %
    under_5, under_10 : thinner
    """

    length: float
    rms: float
    over_5: float
    over_10: float
    under_5: float
    under_10: float


class BeadTally:
    """Widths of beads, by feature, as far as they have come."""

    def __init__(self) -> None:
        self._sums = np.zeros((0, 6))  # of each feature: length, squares, then the lengths that are told of

    def add(self, widths: Widths, feature: np.ndarray) -> None:
        """Count pieces; the feature of each (k,)."""
        if not len(feature):
            return
        missing = int(feature.max()) + 1 - len(self._sums)
        self._sums = np.concatenate([self._sums, np.zeros((max(missing, 0), 6))])
        off = widths.width - 1.0
        told = (np.ones_like(off), off * off, off > 0.05, off > 0.1, off < -0.05, off < -0.1)
        for column, each in enumerate(told):
            self._sums[:, column] += np.bincount(feature, widths.way * each, len(self._sums))

    def figures(self) -> tuple[BeadFigures, dict[int, BeadFigures]]:
        """Of all, and of each feature that was printed."""
        told = {k: _figures(row) for k, row in enumerate(self._sums) if row[0] > 0.0}
        return _figures(self._sums.sum(axis=0)), told


class Beads:
    """The beads of a print that is fed piece by piece."""

    def __init__(self, dt: float):
        self._dt = dt
        self._last: tuple[np.ndarray, ...] | None = None  # samples: path, nozzle, what is pushed, what is wanted
        self._way = 0.0  # so far [mm]
        self._piece = 0  # that goes on: its number, its sums, whether it is printed at speed all along
        self._sums = np.zeros((4, 1))  # way of the path and of the nozzle, pushed, wanted
        self._whole = True

    def add(self, desired: np.ndarray, nozzle: np.ndarray, pushed: np.ndarray, wanted: np.ndarray, prints: np.ndarray,
            begin: np.ndarray) -> Widths:  # fmt: skip
        """Pieces that end in n more samples.

        desired, nozzle : ndarray, shape (n, 2)          [mm]
        pushed, wanted  : ndarray, shape (n,)            filament so far, as executed and as sliced [mm]
        prints          : ndarray of bool, shape (n,)
        begin           : ndarray of int, shape (s,)     samples at which a stretch begins
        """
        if not len(desired):
            return Widths(np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int64))
        rows = (desired, nozzle, pushed[:, None], wanted[:, None])
        last = tuple(row[:1] for row in rows) if self._last is None else self._last
        self._last = tuple(row[-1:].copy() for row in rows)
        joined = [np.concatenate(pair) for pair in zip(last, rows, strict=True)]
        goes = moving(joined[0], self._dt)[1][1:] & prints
        goes[begin] = False
        way, went, pushed, wanted = (_length(row) for row in joined)
        way[~goes] = 0.0
        total = self._way + np.cumsum(way)
        self._way = float(total[-1])
        piece = (total / BEAD).astype(np.int64)
        starts = np.flatnonzero(np.diff(piece, prepend=-1))
        sums = np.add.reduceat(np.stack([way, went, pushed, wanted]), starts, axis=1)
        whole = np.logical_and.reduceat(goes, starts)
        if piece[0] == self._piece:
            sums[:, :1] += self._sums
            whole[0] &= self._whole
        else:
            sums, whole, starts = np.hstack([self._sums, sums]), np.append(self._whole, whole), np.append(-1, starts)
        self._piece, self._sums, self._whole = int(piece[-1]), sums[:, -1:], bool(whole[-1])
        keep = whole[:-1] & (sums[3, :-1] > 0.0) & (sums[1, :-1] > 0.0)
        way, went, pushed, wanted = sums[:, :-1][:, keep]
        return Widths((pushed / went) / (wanted / way), way, starts[1:][keep])


def _figures(sums: np.ndarray) -> BeadFigures:
    length, squares, *beyond = sums.tolist()
    if not length:
        return BeadFigures(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return BeadFigures(length, (squares / length) ** 0.5, *(each / length for each in beyond))


def _length(row: np.ndarray) -> np.ndarray:
    """Displacement to each but the first of the points (n + 1, axes); of one axis with its sign, shape (n,)."""
    step = np.diff(row, axis=0)
    return np.hypot(step[:, 0], step[:, 1]) if step.shape[1] == 2 else step[:, 0]
