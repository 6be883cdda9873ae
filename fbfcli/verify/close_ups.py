"""The worst corners of a print in full resolution: where each method has its largest errors, and what others do there.

Methods have clocks of their own: what another method does at the same place is found by line of the file, then by where
the desired path is.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from fbfcli.verify.passage import Passage

HALF_S = 0.15  # before and after the largest error [s]
EVERY_S = 1e-3  # samples that are closer in time are thinned to about this
APART_MM = 2.0  # corners nearer than this in plan view are one: of a tower's, the worst layer is shown
MARGIN_MM = 0.02  # methods sample the same path at other points of it
WINDOWS = 60  # of the first method's corners, and of all others'; fewer corners are shown where methods are many
LONGEST = 2.0  # times its own window that another method may need for a corner


@dataclass(frozen=True)
class Window:
    """Samples of a method in order, n of them, as they were.

    time            : ndarray, shape (n,)          since the print began [s]
    desired, nozzle : ndarray, shape (n, 2)        X Y [mm]
    error           : ndarray, shape (n,)          of the nozzle from the desired path, + is left of it [mm]
    drawn           : ndarray of bool, shape (n,)  they leave something on the part
    line            : ndarray of int, shape (n,)   of the file, counted from 0
    layer, feature  : ndarray of int, shape (n,)
    """

    time: np.ndarray
    desired: np.ndarray
    nozzle: np.ndarray
    error: np.ndarray
    drawn: np.ndarray
    line: np.ndarray
    layer: np.ndarray
    feature: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: slice | np.ndarray) -> Window:
        """Some of them, without the rest held in memory."""
        return Window(*(np.array(getattr(self, each.name)[rows]) for each in fields(self)))

    def then(self, more: Window) -> Window:
        """This, and what came after it."""
        return Window(*(np.concatenate([getattr(self, each.name), getattr(more, each.name)]) for each in fields(self)))


@dataclass(frozen=True)
class CloseUp:
    """One of a method's largest errors.

    method  : whose
    error   : its size [mm]
    at      : X Y of the desired path there [mm]
    time    : since that method's print began [s]
    line    : of the file, counted from 0
    layer   : counted from 0
    feature : index into the names of the file's features
    windows : of each method that came by
    """

    method: str
    error: float
    at: tuple[float, float]
    time: float
    line: int
    layer: int
    feature: int
    windows: dict[str, Window]


class CloseUps:
    """Collects up to `most` corners of the first method, with what all others do there, and half as many of each other
    one, with what the first does there: the worst ones of everything that is printed, walls, infill, ...
    """

    def __init__(self, most: int):
        self._most = most
        self._found: dict[str, dict[int, list[CloseUp]]] = {}  # of each method, by feature
        self._every = 1  # samples
        self._recent: dict[str, Window] = {}  # what came last, and the end of what came before

    def add(self, name: str, passage: Passage, drawn: np.ndarray) -> None:
        """More of a method; `drawn`, bool, (n,): the samples whose errors count."""
        e = passage.execution
        self._every = max(1, round(EVERY_S / e.dt))
        error = np.copysign(passage.contour, passage.across)
        more = Window(e.time, e.desired, passage.nozzle, error, drawn, e.line, e.layer, e.feature)
        for other, found in self._found.items():
            if self._matters(name, other):
                for feature, corners in found.items():
                    found[feature] = [_joined(corner, name, more, self._every) for corner in corners]
        half = max(1, round(HALF_S / e.dt))
        known = self._recent.get(name)
        before = 0 if known is None else min(2 * half, len(known))
        whole = more if known is None else known[len(known) - before :].then(more)
        self._seek(name, whole, max(0, before - half), len(whole) - half, half)  # later ones may reach into what comes
        self._recent[name] = whole

    def forget(self, name: str) -> None:
        """What was found of a method so far is no part of the print."""
        self._found.pop(name, None)

    def finish(self, dt: float) -> None:
        """The samples held back for windows that might have reached further."""
        half = max(1, round(HALF_S / dt))
        for name, recent in self._recent.items():
            self._seek(name, recent, max(0, len(recent) - half), len(recent), half)
        self._recent = {}

    def corners(self) -> tuple[CloseUp, ...]:
        """Method by method in the order they came, the largest error first."""
        told = []
        for name, found in self._found.items():
            windows = len(self._found) if name == next(iter(self._found)) else 2 * (len(self._found) - 1)  # of each
            some = _shared(list(found.values()), min(self._share(name), WINDOWS // windows))
            told += sorted(some, key=lambda one: -one.error)
        return tuple(told)

    def _share(self, name: str) -> int:
        """Corners of a method that are kept."""
        return self._most if name == next(iter(self._found)) else (self._most + 1) // 2

    def _matters(self, name: str, at: str) -> bool:
        """What a method does at the corners of another is kept."""
        first = next(iter(self._found))
        return name != at and first in (name, at)

    def _seek(self, name: str, samples: Window, first: int, last: int, half: int) -> None:
        """CloseUps whose largest error is in samples[first:last]; windows reach beyond."""
        found, most = self._found.setdefault(name, {}), (self._share(name) + 1) // 2  # of one feature
        if last <= first:
            return
        error = np.where(samples.drawn, np.abs(samples.error), 0.0)[first:last]
        feature = samples.feature[first:last]
        for one in np.unique(feature[error > 0.0]).tolist():
            of_it = np.where(feature == one, error, 0.0)
            self._seek_in(found.setdefault(one, []), name, samples, first, of_it, half, most)

    def _seek_in(
        self, found: list[CloseUp], name: str, samples: Window, first: int, error: np.ndarray, half: int, most: int
    ) -> None:
        """Those of one feature: `error`, shape (n,), is 0 elsewhere."""
        blocks = np.arange(0, len(error), half)
        largest = np.maximum.reduceat(error, blocks)
        for block in np.argsort(-largest, kind="stable").tolist():
            if largest[block] <= (found[-1].error if len(found) >= most else 0.0):
                break
            i = first + int(blocks[block] + np.argmax(error[blocks[block] : blocks[block] + half]))
            corner = _corner(name, samples, i, half, self._every)
            for other, recent in self._recent.items():
                corner = _joined(corner, other, recent, self._every) if self._matters(other, name) else corner
            _take(found, corner, most)


def _shared(found: list[list[CloseUp]], most: int) -> list[CloseUp]:
    """The worst of each, then the second of each, ..., until there are `most`."""
    turns = sorted((rank, -corner.error, i) for i, each in enumerate(found) for rank, corner in enumerate(each))
    return [found[i][rank] for rank, _, i in turns[:most]]


def _take(found: list[CloseUp], corner: CloseUp, most: int) -> None:
    """Put it among those found, unless a worse one is near; those near it that are better go."""
    near = [np.hypot(known.at[0] - corner.at[0], known.at[1] - corner.at[1]) < APART_MM for known in found]
    if any(known.error >= corner.error for known, is_near in zip(found, near, strict=True) if is_near):
        return
    apart = [known for known, is_near in zip(found, near, strict=True) if not is_near]
    found[:] = sorted([*apart, corner], key=lambda one: -one.error)
    del found[most:]


def _corner(name: str, samples: Window, i: int, half: int, every: int) -> CloseUp:
    x, y = samples.desired[i].tolist()
    return CloseUp(
        name, abs(float(samples.error[i])), (x, y), float(samples.time[i]), int(samples.line[i]), int(samples.layer[i]),
        int(samples.feature[i]), {name: samples[i - min(i, half) // every * every : i + half + 1 : every]},
    )  # fmt: skip


def _joined(corner: CloseUp, name: str, more: Window, every: int) -> CloseUp:
    """The corner with those samples of another method that belong to it, each `every`-th of them."""
    own = corner.windows[corner.method]
    if more.line[0] > own.line[-1] or more.line[-1] < own.line[0]:
        return corner
    low, high = own.desired.min(axis=0) - MARGIN_MM, own.desired.max(axis=0) + MARGIN_MM
    here = (more.line >= own.line[0]) & (more.line <= own.line[-1])
    here &= ((more.desired >= low) & (more.desired <= high)).all(axis=1)
    if not here.any():
        return corner
    known, window = corner.windows.get(name), more[np.flatnonzero(here)[::every]]
    window = window if known is None else known.then(window)
    return replace(corner, windows={**corner.windows, name: window[: int(LONGEST * len(own))]})
