"""Make sample_gcode/: `python benchmarks/make_parts.py [folder]`. Needs prusa-slicer and CuraEngine on the path."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import parts
import slicers

Job = tuple[Callable[[], np.ndarray], float, Callable[..., str], dict[str, str]]
SPEEDS = (  # 200 in prusa.ini
    "perimeter_speed", "external_perimeter_speed", "small_perimeter_speed",
    "infill_speed", "solid_infill_speed", "top_solid_infill_speed")  # fmt: skip
SLOWER = dict.fromkeys(SPEEDS, "100")
JOBS: dict[str, Job] = {  # file: solid, its width and length against what `parts` draws, slicer, settings
    "ringing_tower.gcode": (parts.ringing_tower, 1.0, slicers.prusa_slicer, {}),
    "star.gcode": (parts.star, 1.0, slicers.prusa_slicer, {}),
    "curve.gcode": (parts.hull, 1.0, slicers.prusa_slicer, {}),
    "ringing_tower_cura.gcode": (parts.ringing_tower, 1.0, slicers.cura_engine, {}),
    "half_size/ringing_tower.gcode": (parts.ringing_tower, 0.5, slicers.prusa_slicer, SLOWER),
    "half_size/star.gcode": (parts.star, 0.5, slicers.prusa_slicer, SLOWER),
    "half_size/curve.gcode": (parts.hull, 0.5, slicers.prusa_slicer, SLOWER),
}


def sliced(job: Job, gcode: Path) -> None:
    """Write it as G-code."""
    solid, size, slicer, settings = job
    with tempfile.TemporaryDirectory() as scratch:
        stl = Path(scratch) / f"{solid.__name__}.stl"
        stl.write_bytes(parts.stl(solid() * np.array([size, size, 1.0])))
        slicer(stl, gcode.resolve(), **settings)


def main(folder: Path) -> None:
    if hasattr(os, "sched_setaffinity"):  # on several cores PrusaSlicer's lines differ from run to run
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    for name, job in JOBS.items():
        (folder / name).parent.mkdir(exist_ok=True)
        sliced(job, folder / name)
        sys.stderr.write(f"{folder / name}: {(folder / name).stat().st_size} bytes\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "sample_gcode")
