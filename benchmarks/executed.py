"""What a written file does: the desired motion, and what the planner model makes of the segments, on one time base."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.scan import chunks
from fbfcli.pipeline import Settings, Summary, compensate
from fbfcli.plant.model import Plant
from fbfcli.printer import Printer
from fbfcli.verify.contour_error import contour_error
from fbfcli.verify.simulate import Nozzle
from fbfcli.verify.tally import Stretches

STRIDE = 4  # samples between those whose error is measured
SLOW = 1e-3  # mm a sample: slower, a direction means nothing
BEAD = 0.4  # mm: no bead's width changes over less than a nozzle's


@dataclass(frozen=True)
class Executed:
    """Stretches of compensated motion one after the other; n samples, s stretches.

    summary   : Summary
    desired   : ndarray, shape (n, 2)          X Y [mm]
    command   : ndarray, shape (n, 2)          X Y [mm]
    motion    : ndarray, shape (n, 4)          X Y Z E that the planner makes of the written file [mm]
    extruding : ndarray of bool, shape (n,)
    begin     : ndarray of int, shape (s,)     first sample of each stretch
    rest      : ndarray of int, shape (s,)     samples of rest before each
    """

    summary: Summary
    desired: np.ndarray
    command: np.ndarray
    motion: np.ndarray
    extruding: np.ndarray
    begin: np.ndarray
    rest: np.ndarray

    def nozzle(self, plants: tuple[Plant, ...], ahead: tuple[float, ...] = (0.0, 0.0)) -> np.ndarray:
        """Where these plants put the nozzle, shape (n, 2) [mm]; the command comes `ahead` [samples] of its time."""
        y = Nozzle([(plant.b, plant.a) for plant in plants]).follow(self.motion[:, :2], self.begin, self.rest)
        k = np.arange(len(y))
        return np.column_stack([np.interp(k + lag, k, y[:, axis]) for axis, lag in enumerate(ahead)])

    def contour(self, nozzle: np.ndarray) -> float:
        """RMS distance of the nozzle from the path while extruding [mm]."""
        at = np.flatnonzero(self.extruding)[::STRIDE]
        stretch = np.searchsorted(self.begin, at, side="right") - 1
        last = np.append(self.begin[1:], len(self.desired))[stretch] - 1
        return rms(contour_error(nozzle, self.desired, at, self.begin[stretch], last))

    def along(self, nozzle: np.ndarray) -> float:
        """RMS of the error along the path while extruding [mm]."""
        step, moving = self._steps()
        tangent = step[moving] / np.hypot(step[moving, 0], step[moving, 1])[:, None]
        return rms(np.einsum("ij,ij->i", nozzle[moving] - self.desired[moving], tangent))

    def ripple(self, nozzle: np.ndarray, sliced: Executed) -> float:
        """RMS deviation of a bead's width from the sliced one, mm by mm: E per mm of the nozzle's way over E per mm of
        path, in pieces of BEAD.

        sliced : the same print with E on the desired motion's time base
        """
        step, moving = self._steps()
        way = np.where(moving, np.hypot(*step.T), 0.0)
        piece = (np.cumsum(way) / BEAD).astype(np.int64)
        first = np.flatnonzero(np.diff(piece, prepend=-1))
        went = np.hypot(*np.diff(nozzle, axis=0, prepend=nozzle[:1]).T)
        pushed, wanted = (np.diff(each.motion[:, 3], prepend=0.0) for each in (self, sliced))
        way, went, pushed, wanted = (np.add.reduceat(each, first) for each in (way, went, pushed, wanted))
        whole = np.logical_and.reduceat(moving, first) & (wanted > 0.0)
        width = (pushed[whole] / went[whole]) / (wanted[whole] / way[whole])
        return float(np.sqrt(np.average((width - 1.0) ** 2, weights=way[whole])))

    def _steps(self) -> tuple[np.ndarray, np.ndarray]:
        """Desired displacement of each sample, (n, 2), and the samples that print at speed, bool, (n,)."""
        step = np.diff(self.desired, axis=0, prepend=self.desired[:1])
        return step, self.extruding & (np.hypot(*step.T) > SLOW)


def executed(text: bytes, printer: Printer, settings: Settings) -> Executed:
    """Compensate a text and execute what is written."""
    parts: list[tuple[np.ndarray, ...]] = []
    n = 0

    def keep(part: Stretches) -> None:
        nonlocal n
        new = 1 if part.begun else 0
        motion = part.positions(slice(4))
        rows = (part.desired, part.command, motion, part.extruding, part.begin + n - new, part.rest)
        parts.append(tuple(each[new:] for each in rows))
        n += len(part.desired) - new

    done = compensate(chunks(io.BytesIO(text)), printer, settings, lambda written: None, watch=keep)
    return Executed(done.summary, *(np.concatenate(column) for column in zip(*parts, strict=True)))


def rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(error)))) if len(error) else 0.0
