"""Slice a solid headless, with the settings beside this file: PrusaSlicer and CuraEngine."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

CENTRE = 125.0  # of the bed that the settings describe [mm]
FOLDER = Path(__file__).parent


def prusa_slicer(stl: Path, gcode: Path, **settings: str) -> str:
    """Slice with PrusaSlicer. Settings as on its command line: post_process="..."; returns what it said."""
    extra = [f"--{key.replace('_', '-')}={value}" for key, value in settings.items()]
    return _run(["prusa-slicer", "--export-gcode", "--load", str(FOLDER / "prusa.ini"),
                 "--center", f"{CENTRE:g},{CENTRE:g}", *extra, "--output", str(gcode), stl.name], stl.parent)


def cura_engine(stl: Path, gcode: Path, **settings: str) -> str:
    """Slice with CuraEngine 4, and do what Cura does after it: put the header that is known at the end at the start.

    The engine has no defaults of its own: cura.json names every setting it asks for.
    """
    every = json.loads((FOLDER / "cura.json").read_text()) | settings
    words = [word for key, value in every.items() for word in ("-s", f"{key}={value}")]
    said = _run(["CuraEngine", "slice", "-v", "-m1", *words, "-e0", "-l", stl.name, "-o", str(gcode)], stl.parent)
    if not gcode.is_file() or "no value given" in said:
        raise RuntimeError(f"CuraEngine: {said[-400:]}")
    header = said.split("Gcode header after slicing:\n")[1].split("End of gcode header.")[0]
    body = gcode.read_text().split("\n\n", 1)[1]
    gcode.write_text(header + "\n" + body)
    return said


def _run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace",
                          stdin=subprocess.DEVNULL, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed with {done.returncode}: {(done.stderr or done.stdout)[-400:]}")
    return done.stdout + done.stderr
