"""What a machine makes of corners: how far it cuts them, how far it goes past, and how long it rings on the wall after.

What people see are waves in the wall behind a corner: amplitude across it, wavelength along it (speed / frequency).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.units import UM_PER_MM
from fbfcli.verify.contour_error import reach
from fbfcli.verify.corners import Corners, corners
from fbfcli.verify.held_back import HeldBack, Ready
from fbfcli.verify.passage import Passage

WINDOW_S = 0.25  # after a corner; what rings longer has rung enough to be measured
PAUSE_S = 0.005  # a rest that ends a wall
WAVES = 8  # half waves that are looked at
LEAST_UM = 1.0  # a smaller swing is no ringing: its wavelength means nothing
LOWEST = 5.0  # Hz: what changes sign more slowly is no ringing either
AT_ONCE = 1 << 20  # samples of windows that are looked at together


@dataclass(frozen=True)
class Corner:
    """One corner that was printed; c of them.

    line, layer, feature : ndarray of int, shape (c,)   of what is printed after it
    axis      : ndarray of int, shape (c,)              0, 1: X or Y swings across that wall most
    time      : ndarray, shape (c,)                     [s]
    point     : ndarray, shape (c, 2)                   [mm]
    turn      : ndarray, shape (c,)                     [rad]
    rounding  : ndarray, shape (c,)                     nearest that the nozzle comes to it [mm]
    overshoot : ndarray, shape (c,)                     how far it goes past the wall after, to the outside [mm]
    amplitude : ndarray, shape (c,)                     of the first swing across the wall after that [mm]
    decay     : ndarray, shape (c,)                     of the next half wave, a part of it; nan where there is none
    wavelength : ndarray, shape (c,)                    on the part [mm]; nan where nothing rings
    frequency : ndarray, shape (c,)                     [Hz]; nan where nothing rings
    """

    line: np.ndarray
    layer: np.ndarray
    feature: np.ndarray
    axis: np.ndarray
    time: np.ndarray
    point: np.ndarray
    turn: np.ndarray
    rounding: np.ndarray
    overshoot: np.ndarray
    amplitude: np.ndarray
    decay: np.ndarray
    wavelength: np.ndarray
    frequency: np.ndarray

    def __len__(self) -> int:
        return len(self.line)


class Ringing:
    """The corners of a print that comes in pieces."""

    def __init__(self) -> None:
        self._held: HeldBack | None = None
        self._dt = 0.0

    def add(self, passage: Passage) -> Corner | None:
        """Corners that are final with more of the print; None: none."""
        here = passage.execution
        if self._held is None:
            self._dt = here.dt
            self._held = HeldBack(max(round(WINDOW_S / self._dt), reach(self._dt)))
        pauses = here.begin[here.rest > PAUSE_S / self._dt]
        rows = (here.desired, passage.nozzle, here.extruding, here.line, here.layer, here.feature, here.time)
        return self._corners(self._held.add(rows, pauses, goes_on=True))

    def finish(self) -> Corner | None:
        """Those that are left; no more will come."""
        rest = self._held.rest() if self._held else None
        return self._corners(rest) if rest else None

    def _corners(self, ready: Ready) -> Corner | None:
        desired, nozzle, extruding, line, layer, feature, time = ready.rows
        found = corners(desired, ready.begin, self._dt)
        ends = np.minimum(ready.stretch(found.last)[1], np.append(found.first[1:], len(desired) - 1))
        now = (found.last >= ready.at.start) & (found.last < ready.at.stop) & extruding[found.last]
        found, ends = found[now], ends[now]
        if not len(found):
            return None
        size = max(AT_ONCE // round(WINDOW_S / self._dt), 1)
        parts = [
            self._measured(found[k : k + size], ends[k : k + size], desired, nozzle, extruding)
            for k in range(0, len(found), size)
        ]
        at = found.last
        return Corner(
            line=line[at],
            layer=layer[at],
            feature=feature[at],
            axis=(np.abs(found.left[:, 1]) > np.abs(found.left[:, 0])).astype(np.int64),
            time=time[found.first],
            point=found.point,
            turn=found.turn,
            **{name: np.concatenate([part[name] for part in parts]) for name in parts[0]},
        )

    def _measured(self, found: Corners, ends: np.ndarray, desired: np.ndarray, nozzle: np.ndarray,
                  extruding: np.ndarray) -> dict[str, np.ndarray]:  # fmt: skip
        """Of corners whose walls end at `ends` (c,)."""
        window = np.arange(round(WINDOW_S / self._dt))
        k = found.first[:, None] + window  # from before it: what the nozzle lags by there is no swing yet
        inside = k <= ends[:, None]
        k = np.minimum(k, ends[:, None])
        inside &= np.logical_and.accumulate(extruding[np.maximum(k, found.last[:, None])], axis=1)
        error = nozzle[k] - desired[k]
        across = np.where(inside, (error * found.left[:, None]).sum(axis=2), 0.0)
        straight_on = (np.abs((found.outward * found.left).sum(axis=1)) < 0.5)[:, None, None]
        past = np.where(straight_on, nozzle[k] - found.point[:, None], error)
        after = inside & (k >= found.last[:, None])
        past = np.where(after, (past * found.outward[:, None]).sum(axis=2), 0.0)
        step = np.hypot(*np.diff(desired[k], axis=1, prepend=desired[k[:, :1]]).transpose(2, 0, 1))
        return {
            "rounding": self._nearest(found, ends, nozzle, desired),
            "overshoot": np.maximum(past.max(axis=1), 0.0),
            **_waves(across, np.cumsum(step, axis=1), self._dt),
        }

    def _nearest(self, found: Corners, ends: np.ndarray, nozzle: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """How near the nozzle comes to each corner, (c,): nearer than that the path itself does not come."""
        around = np.arange(-reach(self._dt) // 2, reach(self._dt))
        k = np.clip(found.last[:, None] + around, 0, ends[:, None])
        a, b = (((path[k] - found.point[:, None]) ** 2).sum(axis=2).min(axis=1) ** 0.5 for path in (nozzle, desired))
        return np.asarray(np.maximum(a - b, 0.0))


def _waves(across: np.ndarray, way: np.ndarray, dt: float) -> dict[str, np.ndarray]:
    """Swings of errors across walls, (c, n), against the way along them, (c, n): between their changes of sign."""
    c, n = across.shape
    changes = (across[:, 1:] * across[:, :-1]) < 0.0
    which = np.cumsum(changes, axis=1)
    size = np.abs(across[:, 1:])
    peaks = np.stack([_peak(np.where(which == i, size, 0.0)) for i in range(1, 4)], axis=1)
    amplitude = peaks[:, 0]
    counted = changes & (which <= WAVES)
    many = counted.sum(axis=1)
    first = counted.argmax(axis=1)
    last = n - 2 - counted[:, ::-1].argmax(axis=1)
    row = np.arange(c)
    t, s = ([_crossing(across, each, row, at) for at in (first, last)] for each in (dt * np.arange(n), way))
    halves = many - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        frequency = halves / 2.0 / (t[1] - t[0])
        rings = (halves >= 2) & (UM_PER_MM * amplitude > LEAST_UM) & (frequency > LOWEST)
        return {
            "amplitude": amplitude,
            "decay": np.where(rings, peaks[:, 1] / peaks[:, 0], np.nan),
            "wavelength": np.where(rings, 2.0 * (s[1] - s[0]) / halves, np.nan),
            "frequency": np.where(rings, frequency, np.nan),
        }


def _crossing(across: np.ndarray, along: np.ndarray, row: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Where, on `along` (n,) or (c, n), the error goes through zero after sample `at` (c,)."""
    a, b = across[row, at], across[row, at + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(a != b, a / (a - b), 0.0)
    x, y = (along[at], along[at + 1]) if along.ndim == 1 else (along[row, at], along[row, at + 1])
    return np.asarray(x + part * (y - x))


def _peak(size: np.ndarray) -> np.ndarray:
    """The top of each row, (c,), between samples: of the parabola through the largest and its neighbours."""
    c, n = size.shape
    row, at = np.arange(c), size.argmax(axis=1)
    mid = np.clip(at, 1, n - 2)
    low, top, high = size[row, mid - 1], size[row, mid], size[row, mid + 1]
    bend = low - 2.0 * top + high
    inner = (at == mid) & (bend < 0.0) & (low > 0.0) & (high > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(inner, top - (high - low) ** 2 / (8.0 * bend), size[row, at])
