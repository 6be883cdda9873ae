"""What a user says beside the recordings that are to be identified."""

from __future__ import annotations

from dataclasses import dataclass, field

from fbfcli.plant.excitation import Sweep
from fbfcli.plant.recording import ReadOptions


@dataclass(frozen=True)
class Ask:
    """What a user says beside the recordings.

    axis      : 'x', 'y', or None: the file tells
    sweep     : the test that was run, None: found or told by the file
    band      : [Hz]
    averaging : of plant.spectra.AVERAGING
    estimator : of plant.frf.ESTIMATORS
    error     : [mm], that accelerations are told for
    dt        : period of a discrete model [s]
    read      : how files are to be read
    """

    axis: str | None = None
    sweep: Sweep | None = None
    band: tuple[float, float] = (5.0, 200.0)
    averaging: str = "short-time"
    estimator: str = "h1"
    error: float = 0.05
    dt: float = 1e-3
    read: ReadOptions = field(default_factory=ReadOptions)
