"""Moves against the machine's travel."""

from __future__ import annotations

import numpy as np

from fbfcli.errors import GcodeError
from fbfcli.motion.moves import Moves

EPS_MM = 1e-6  # rounding of sums of words


def check_travel(moves: Moves, known: np.ndarray, travel: tuple[tuple[float, float], ...]) -> None:
    """Refuse the first move that ends outside the travel of an axis.

    known  : ndarray of bool, shape (n,)   moves after which the position is known
    travel : (low, high) of X, Y and so on [mm]
    Raises GcodeError with the line, the coordinate and the remedy.
    """
    end = moves.start[:, : len(travel)] + moves.delta[:, : len(travel)]
    low, high = np.array(travel).T
    outside = known[:, None] & ((end < low - EPS_MM) | (end > high + EPS_MM))
    if outside.any():
        i, axis = (int(k) for k in np.argwhere(outside)[0])
        raise GcodeError(
            f"{'XYZ'[axis]}{end[i, axis]:g} is outside the printer's travel {low[axis]:g} to {high[axis]:g} mm",
            line=int(moves.line[i]) + 1,
            remedy="move the part on the bed, or correct `travel` in the printer profile",
        )
