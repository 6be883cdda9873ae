"""Segments against Klipper's rule for how thick a line may be."""

from __future__ import annotations

from math import pi

import numpy as np

from fbfcli.errors import LimitError
from fbfcli.motion.moves import E, Moves


def check_extrusion(moves: Moves, nozzle_diameter: float, filament_diameter: float, cross_section: float) -> None:
    """Refuse segments at which Klipper would abort the print (klippy/kinematics/extruder.py, check_move).

    A move may push E per mm of path up to cross_section over the filament's area; thicker ones only up to the nozzle's
    diameter times that ratio. Raises LimitError.
    """
    ratio = cross_section / (pi * (filament_diameter / 2) ** 2)
    push = moves.delta[:, E]
    bad = np.flatnonzero((push > ratio * moves.distance) & (push > nozzle_diameter * ratio))
    if len(bad):
        i = int(bad[0])
        x, y = moves.start[i, :2]
        raise LimitError(
            f"at X{x:.3f} Y{y:.3f} a segment would push {push[i]:.3f} mm of filament in {moves.distance[i]:.3f} mm, "
            "which Klipper refuses; raise max_extrude_cross_section there and in the profile, or lower --accel"
        )
