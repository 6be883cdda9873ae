"""A piece of a print as a machine draws it: the nozzle, and how far it is from where it should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.verify.execution import Execution


@dataclass(frozen=True)
class Passage:
    """What one machine makes of an execution; n samples, the same as its.

    execution : Execution
    nozzle    : ndarray, shape (n, 2)   X Y [mm]
    tracking  : ndarray, shape (n,)     distance of the nozzle from where it should be now [mm]
    contour   : ndarray, shape (n,)     distance of the nozzle from the desired path [mm]
    across    : ndarray, shape (n,)     nozzle - desired along the path's left normal [mm]
    along     : ndarray, shape (n,)     and along the path, ahead positive [mm]
    """

    execution: Execution
    nozzle: np.ndarray
    tracking: np.ndarray
    contour: np.ndarray
    across: np.ndarray
    along: np.ndarray

    def __len__(self) -> int:
        return len(self.nozzle)
