"""From commands to segments: nodes, words, and speeds under which the firmware keeps time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fbfcli.errors import LimitError
from fbfcli.gcode.placement import Places, forced, segment_of
from fbfcli.gcode.raised import raised
from fbfcli.gcode.words import SCALE
from fbfcli.gcode.write import Modes, Words, feed_of, speed_of, words_of
from fbfcli.motion.budget import Budget
from fbfcli.motion.extrusion import check_extrusion
from fbfcli.motion.moves import Moves
from fbfcli.motion.nodes import break_points, thinned
from fbfcli.motion.planner import Part
from fbfcli.motion.polyline import Polyline, fit, fit_through
from fbfcli.motion.profile import Profile
from fbfcli.motion.stretches import kinks
from fbfcli.motion.timing import lateness, timed
from fbfcli.pipeline.commander import Batch
from fbfcli.printer import Limits, Printer

EDGE_MM = 1e-4  # kept from the end of the travel: rounding, and nodes that are nudged apart


@dataclass(frozen=True)
class Segments:
    """Segments between the nodes of a batch, k of them with the gaps between stretches, r without.

    node   : ndarray of int, shape (k + 1,)   samples
    words  : Words                            of all k
    modes  : Modes                            in force for each of the k
    feed   : ndarray of int64, shape (k,)     F words, 0 for a gap
    first  : ndarray of int, shape (s,)       segment (of k) that begins each stretch
    moves  : Moves                            the r real ones as the firmware reads them
    wanted : ndarray, shape (r,)              time each should last [s]
    done   : Profile                          what the planner model makes of them
    late   : float                            how late the first starts [s]
    """

    node: np.ndarray
    words: Words
    modes: Modes
    feed: np.ndarray
    first: np.ndarray
    moves: Moves
    wanted: np.ndarray
    done: Profile
    late: float

    @property
    def elapsed(self) -> np.ndarray:
        """Time of the segments before each node [s], shape (k + 1,)."""
        duration = np.zeros(len(self.words.real))
        duration[self.words.real] = self.done.duration
        return np.concatenate([[0.0], np.cumsum(duration)])


class Segmenter:
    """Cuts the commands of one file into segments, batch by batch."""

    def __init__(self, printer: Printer, plants: Sequence[tuple[np.ndarray, np.ndarray]], budget: Budget, dt: float):
        self._printer, self._plants, self._budget, self.dt = printer, plants, budget, dt
        self._late = 0.0  # where a stretch goes on in the next batch [s]

    def segments(self, batch: Batch, part: Part, places: Places, before: Modes, bases: list[Limits]) -> Segments:
        """Segments of a batch.

        places : of the lines written with it
        before : modes (one place) in force before the first of these lines
        bases  : the file's limits, one per stretch, that were raised when its run began
        """
        n = len(batch.command)
        ends = np.column_stack([batch.begin, batch.end]).ravel()
        node = break_points(batch.command, ends, self._needed(batch, part, places), self.dt, self._budget)
        is_end = np.zeros(n, dtype=bool)
        is_end[ends] = True
        pinned = is_end[node]
        position = np.column_stack([self._fitted(batch.command, node, pinned), batch.desired[node, 2:]])
        if not np.isfinite(position).all():
            raise LimitError("a compensated position is not finite")
        first = np.searchsorted(node, batch.begin)
        real = np.ones(len(node) - 1, dtype=bool)
        real[first[1:] - 1] = False
        rows = before.then(places.lines.modes(places.e_machine))
        at = segment_of(places.sample, node)
        modes = rows[np.searchsorted(at, np.arange(len(real)), side="right")]
        words = words_of(position, modes, real, ~pinned)
        return self._timed(node, words, modes, first, batch, bases)

    def _fitted(self, u: np.ndarray, node: np.ndarray, pinned: np.ndarray) -> np.ndarray:
        """X and Y of the nodes, within the travel."""
        xy = self._best(u, node, pinned)
        while (lost := self._ends_of_lost(xy, node) & (xy != u[node]).any(axis=1)).any():
            xy[lost] = u[node[lost]]
        low, high = np.array([axis.travel for axis in self._printer.axes[:2]]).T
        inside = np.clip(xy, low + EDGE_MM, high - EDGE_MM)  # a node beyond the travel would end the print
        return np.where(pinned[:, None], xy, inside)

    def _best(self, u: np.ndarray, node: np.ndarray, pinned: np.ndarray) -> np.ndarray:
        """Nodes nearest to the command; where they are too few for the tolerance, those best for the nozzle."""
        polyline = Polyline(node, pinned)
        xy = fit(u, polyline)
        lost = self._ends_of_lost(xy, node) & ~pinned
        if lost.any():
            polyline = Polyline(node, pinned | lost)
            xy = fit(u, polyline)
        off = u - np.column_stack([polyline.curve(xy[:, axis]) for axis in range(2)])
        if np.einsum("ij,ij->", off, off) > len(u) * self._budget.tolerance**2:
            return fit_through(xy, u, polyline, self._plants)
        return xy

    def _ends_of_lost(self, xy: np.ndarray, node: np.ndarray) -> np.ndarray:
        """Nodes of segments that the firmware would lose: these are better on the command itself; bool, shape (m,)."""
        lost = self._budget.is_lost(np.abs(np.diff(xy, axis=0)).max(axis=1), self.dt * np.diff(node))
        return np.append(lost, False) | np.append(False, lost)

    def _needed(self, batch: Batch, part: Part, places: Places) -> np.ndarray:
        """Samples that must be nodes: E or Z changes its speed, or a line wants its time."""
        last = len(batch.command) - 1
        bends = kinks(part.moves, part.profile, batch.grid)
        wanted = np.concatenate([bends[(bends > 0) & (bends < last)], forced(places, 0, last)])
        return thinned(np.sort(wanted), self.dt, self._budget)

    def _timed(
        self, node: np.ndarray, words: Words, modes: Modes, first: np.ndarray, batch: Batch, bases: list[Limits]
    ) -> Segments:
        here = np.flatnonzero(words.real)
        unit, factor = words.unit[here], modes.speed_factor[here]
        stop = np.zeros(len(words.real), dtype=bool)
        stop[first[1 if batch.begun else 0 :]] = True
        limits = tuple(dict.fromkeys(bases))
        stretch = np.searchsorted(first, here, side="right") - 1
        moves = Moves(
            start=words.begin[here] * (unit[:, None] / SCALE) + modes.offset[here],
            delta=words.delta[here],
            speed=np.ones(len(here)),
            stop=stop[here],
            state=np.array([limits.index(base) for base in bases])[stretch],
            line=np.zeros(len(here), dtype=np.int64),
            limits=tuple(raised(self._printer.firmware, base) for base in limits),
        )
        if self._printer.firmware == "klipper":
            nozzle, filament = self._printer.nozzle_diameter, self._printer.filament_diameter
            check_extrusion(moves, nozzle, filament, self._printer.max_extrude_cross_section)
        wanted = np.diff(node)[here] * self.dt

        def quantise(speed: np.ndarray) -> np.ndarray:
            return speed_of(feed_of(speed, unit, factor), unit, factor)

        moves, done = timed(moves, wanted, self._late, self._printer.firmware, quantise, batch.begun, batch.goes_on)
        late, starts = self._late, np.flatnonzero(moves.stop)
        self._late = float(lateness(done.duration - wanted, starts, late)[-1]) if batch.goes_on else 0.0
        feed = np.zeros(len(words.real), dtype=np.int64)
        feed[here] = feed_of(moves.speed, unit, factor)
        return Segments(node, words, modes, feed, first, moves, wanted, done, late)
