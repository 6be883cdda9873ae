"""What a firmware takes of the segments that are sent to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MARLIN_STEPS = 6  # MIN_STEPS_PER_SEGMENT: Marlin merges or drops moves of fewer
BURST = 8.0  # segments: half of the smallest queue (16), so that corners may have more and straight lines fewer
FITTED = 4.0  # tolerances that a fit may move nodes towards each other
ROOM = 1.1  # segments are planned this much longer than the shortest that the firmware keeps: the fit moves nodes
ROUNDED = 2e-5  # mm that five decimals and a nudge may take from a segment


@dataclass(frozen=True)
class Budget:
    """What segments may be.

    tolerance  : largest distance of a chord from the command [mm]
    max_rate   : segments per second that the firmware takes in the long run, BURST more at once [1/s]
    min_length : shorter segments are dropped by the firmware [mm]
    min_speed  : slower ones are sped up by it [mm/s]
    """

    tolerance: float
    max_rate: float
    min_length: float = 0.0
    min_speed: float = 0.0

    @property
    def has_shortest(self) -> bool:
        """Not every segment is taken as it is."""
        return self.min_length > 0 or self.min_speed > 0

    def is_lost(self, step: np.ndarray, lasts: np.ndarray) -> np.ndarray:
        """Segments that the firmware drops or speeds up, bool; `step` [mm] along the axis that moves most, time [s]."""
        return step - ROUNDED < np.maximum(self.min_length, self.min_speed * lasts)

    def is_short(self, step: np.ndarray, lasts: np.ndarray) -> np.ndarray:
        """Chords of the command that might be so once their ends are fitted."""
        fitted = step - FITTED * self.tolerance if self.min_speed > 0 else step
        return (step < ROOM * self.min_length) | (fitted < self.min_speed * lasts)
