"""Filament in step with where the nozzle is expected, batch by batch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fbfcli.motion.filament import following
from fbfcli.motion.moves import E
from fbfcli.pipeline.choice import FAMILY_METHODS
from fbfcli.pipeline.commander import Batch
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.settings import Settings
from fbfcli.verify.simulate import Nozzle

REST = 200  # samples assumed between stretches: what still vibrates then is little


class Filament:
    """E of one print. Where a stretch goes on in the next batch, E is there what it was to be."""

    def __init__(self, designs: Designs, settings: Settings):
        follows = designs.method in FAMILY_METHODS if settings.with_nozzle is None else settings.with_nozzle
        self._nozzle = Nozzle(designs.mean) if follows else None

    def pushed(self, batch: Batch) -> Batch:
        """The batch with E as it is to be written."""
        if self._nozzle is None or not len(batch.command):
            return batch
        new = 1 if batch.begun else 0  # a stretch that goes on: its sample 0 was the last one before
        begin = batch.begin[new:] - new
        expected = self._nozzle.follow(batch.command[new:], begin, np.full(len(begin), REST), batch.place[new:])
        desired = batch.desired.copy()
        first = np.union1d([0], begin)
        desired[new:, E] = following(desired[new:, E], desired[new:, :2], expected, first)
        return replace(batch, desired=desired)
