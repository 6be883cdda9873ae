"""A piece of a print as the firmware executes it: where the nozzle should be, and where the motors are sent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Execution:
    """n samples, one every `dt`, in order; s stretches of motion that begin in them.

    dt        : float                          [s]
    begin     : ndarray of int, shape (s,)     samples at which a stretch begins; those before the first go on with the
                                               stretch of the piece before
    rest      : ndarray of int, shape (s,)     samples of rest before each
    goes_on   : bool                           the last stretch goes on in the next piece
    time      : ndarray, shape (n,)            since the print began [s]
    line      : ndarray of int, shape (n,)     line of the file that asks for it, counted from 0
    layer     : ndarray of int, shape (n,)     counted from 0
    feature   : ndarray of int, shape (n,)     what is printed: index into the names of the file's features
    desired   : ndarray, shape (n, 2)          X Y [mm]
    command   : ndarray, shape (n, 2)          X Y that the method asks for [mm]
    motion    : ndarray, shape (n, 4)          X Y Z E that the firmware makes of the written file [mm]
    extruding : ndarray of bool, shape (n,)
    place     : ndarray of int, shape (n,)     where the print is; None: the plants hold everywhere
    filament  : ndarray, shape (n,)            E as sliced, on the desired time base [mm]; None: that of `motion`
    """

    dt: float
    begin: np.ndarray
    rest: np.ndarray
    goes_on: bool
    time: np.ndarray
    line: np.ndarray
    layer: np.ndarray
    feature: np.ndarray
    desired: np.ndarray
    command: np.ndarray
    motion: np.ndarray
    extruding: np.ndarray
    place: np.ndarray | None = None
    filament: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.desired)
