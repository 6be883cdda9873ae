"""What a written file does: the desired motion, and what the planner model makes of the segments, on one time base."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.scan import chunks
from fbfcli.pipeline import Settings, Summary, compensate
from fbfcli.plant.model import Plant
from fbfcli.printer import Printer
from fbfcli.verify.bead import Beads
from fbfcli.verify.contour_error import contour_error
from fbfcli.verify.heading import Heading, along_and_across, moving
from fbfcli.verify.held_back import stretch_ends
from fbfcli.verify.simulate import Nozzle
from fbfcli.verify.tally import Stretches

STRIDE = 4  # samples between those whose error is measured


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
    dt        : float                          [s]
    """

    summary: Summary
    desired: np.ndarray
    command: np.ndarray
    motion: np.ndarray
    extruding: np.ndarray
    begin: np.ndarray
    rest: np.ndarray
    dt: float

    def nozzle(self, plants: tuple[Plant, ...], ahead: tuple[float, ...] = (0.0, 0.0)) -> np.ndarray:
        """Where these plants put the nozzle, shape (n, 2) [mm]; the command comes `ahead` [samples] of its time."""
        y = Nozzle([(plant.b, plant.a) for plant in plants]).follow(self.motion[:, :2], self.begin, self.rest)
        k = np.arange(len(y))
        return np.column_stack([np.interp(k + lag, k, y[:, axis]) for axis, lag in enumerate(ahead)])

    def contour(self, nozzle: np.ndarray) -> float:
        """RMS distance of the nozzle from the path while extruding [mm]."""
        at = np.flatnonzero(self.extruding)[::STRIDE]
        first, last = stretch_ends(at, self.begin, len(self.desired))
        return rms(contour_error(nozzle, self.desired, at, first, last, self.dt))

    def along(self, nozzle: np.ndarray) -> float:
        """RMS of the error along the path while it is printed at speed [mm]."""
        at = self.extruding & moving(self.desired, self.dt)[1]
        heading = Heading(self.dt).follow(self.desired, self.begin)
        return rms(along_and_across(nozzle - self.desired, heading)[0][at])

    def ripple(self, nozzle: np.ndarray, sliced: Executed) -> float:
        """RMS deviation of a bead's width from the sliced one, mm by mm.

        sliced : the same print with E on the desired motion's time base
        """
        pushed, wanted = self.motion[:, 3], sliced.motion[:, 3]
        return Beads(self.dt).add(self.desired, nozzle, pushed, wanted, self.extruding, self.begin).rms


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
    return Executed(done.summary, *(np.concatenate(column) for column in zip(*parts, strict=True)), settings.dt)


def rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(error)))) if len(error) else 0.0
