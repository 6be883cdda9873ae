"""The motion of a G-code file, sampled: what its plan asks for and what a method makes of it."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np

from fbfcli.gcode.scan import chunks
from fbfcli.motion.profile import Profile
from fbfcli.pipeline import Settings
from fbfcli.pipeline.choice import chosen
from fbfcli.pipeline.commander import Batch, Commander
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.reader import Reader
from fbfcli.printer import Printer
from fbfcli.verify.simulate import Nozzle


@dataclass(frozen=True)
class Motion:
    """Stretches of compensated motion one after the other; n samples, s stretches.

    desired   : ndarray, shape (n, 4)          X Y Z E [mm]
    command   : ndarray, shape (n, 2)          X Y [mm]
    extruding : ndarray of bool, shape (n,)
    begin     : ndarray of int, shape (s,)     first sample of each stretch
    rest      : ndarray of int, shape (s,)     samples of other motion before each; dwells are not counted
    """

    desired: np.ndarray
    command: np.ndarray
    extruding: np.ndarray
    begin: np.ndarray
    rest: np.ndarray

    def nozzle(self, printer: Printer, settings: Settings) -> np.ndarray:
        """Where the printer's models put the nozzle, shape (n, 2) [mm]."""
        return Nozzle(Designs(printer, "none", settings).b_a(0)).follow(self.command, self.begin, self.rest)


def motion(text: bytes, printer: Printer, settings: Settings) -> Motion:
    """The motion of a file under the planner and the method of the settings. Raises what `compensate` raises."""
    commander = Commander(Designs(printer, chosen(printer, settings).method, settings), settings.dt)
    rows: list[tuple[np.ndarray, ...]] = []
    begin: list[np.ndarray] = []
    rest: list[np.ndarray] = []
    n, waited = 0, 0.0
    for portion in Reader(printer, settings).portions(chunks(io.BytesIO(text)), lambda done: None):
        batch = commander.batch(portion.part, portion.inside)
        new = slice(1 if batch.begun else 0, None)
        pause, waited = _rests(batch, portion.part.profile, portion.inside, waited)
        begin.append(batch.begin[new] + n)
        rest.append(np.rint(pause[new] / settings.dt).astype(np.int64))
        rows.append(tuple(part[: batch.dropped] for part in (batch.desired, batch.command, batch.extruding)))
        n += len(rows[-1][0])
    desired, command, extruding = (np.concatenate(column) for column in zip(*rows, strict=True))
    return Motion(desired, command, extruding, np.concatenate(begin), np.concatenate(rest))


def _rests(batch: Batch, profile: Profile, inside: np.ndarray, waited: float) -> tuple[np.ndarray, float]:
    """Time before each stretch that other moves take, and after the last one, [s]; `waited` before the first move."""
    idle = np.concatenate([[0.0], np.cumsum(np.where(inside, 0.0, profile.duration))])
    passed = waited + idle[batch.start]
    last = float(passed[-1]) if len(passed) else 0.0
    return np.diff(passed, prepend=0.0), waited + float(idle[-1]) - last
