"""The picture of what was identified: which one, by what there is to show."""

from __future__ import annotations

from pathlib import PurePath

import numpy as np

from fbfcli.pipeline.identified import Identified
from fbfcli.plant.bode import bode_picture, decay_picture, power_picture
from fbfcli.plant.intervals import draws

DRAWS, SEED = 60, 1


def picture(found: Identified, kind: str) -> bytes:
    """The picture as a file: png, svg or pdf."""
    modes = [mode.frequency.value for mode in found.modes]
    captures = [(PurePath(one.name).name, one.fs, one.y) for one in found.captures]
    names = ", ".join(PurePath(name).name for name in found.source)
    title = f"axis {found.axis}: {names}" + (f"\nassumed: {found.assumed}" if found.assumed else "")
    if found.measured is not None:
        best = found.measured.candidates[0]
        outside = float(np.exp(best.theta[0])), float(best.theta[1]), float(best.theta[2])
        possible = draws(best, found.measured.covariance, DRAWS, np.random.default_rng(SEED))
        return bode_picture(title, found.measured.frf, outside, found.rational, possible, modes, found.measured.groups,
                            captures, kind)  # fmt: skip
    if found.decay is not None:
        return decay_picture(title, found.decay.t, found.decay.y, found.decay.fitted, captures, kind)
    f, power, rise = found.power if found.power else (np.zeros(0), np.zeros(0), 0.0)
    return power_picture(title, f, power, rise, found.rational, modes, kind)
