"""A piece of a print as a machine draws it: the nozzle, and how far it is from where it should be."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

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

    def __getitem__(self, rows: slice) -> Passage:
        """Some samples one after the other."""
        a, b, _ = rows.indices(len(self))
        whole = self.execution
        here = (whole.begin >= a) & (whole.begin < b)
        columns: dict[str, Any] = {
            each.name: column[a:b]
            for each in fields(whole)
            if each.name not in ("begin", "rest") and isinstance(column := getattr(whole, each.name), np.ndarray)
        }
        execution = replace(
            whole, begin=whole.begin[here] - a, rest=whole.rest[here], goes_on=whole.goes_on or b < len(self), **columns
        )
        own = (getattr(self, each.name)[a:b] for each in fields(self) if each.name != "execution")
        return Passage(execution, *own)
