"""Speed of the methods that know a family of plants: `python benchmarks/bench_contour.py`.

Print-seconds per CPU-second of the compensation step alone (desired positions in, commands out), on one core, for the
plants of `robustness.py`. `--limited` adds contour where the machine stands little more than the plan asks for, so that
most windows are solved again within limits. `--slow` instead designs `robust` for a slow, lightly damped axis,
whose robust filter begins seconds early, and tells the design's time and the program's peak memory.
"""

from __future__ import annotations

import argparse
import resource
import time
from dataclasses import replace

import numpy as np
from robustness import PLANTS, ROOT, printer_of
from trajectory import Motion, motion

from fbfcli.control.compensator import Compensator
from fbfcli.pipeline import Settings
from fbfcli.pipeline.designs import Designs
from fbfcli.printer import ModalModel, Mode, Printer

PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
METHODS = ("lpfbs", "robust", "contour")
LEAST = 400.0  # print-seconds per CPU-second
REPEATS = 3
MB = 1e6
CLOSE = 1.1  # --limited: command_acceleration over the plan's
SLOW = ModalModel((Mode(15.0, 0.03),))  # --slow: of X


def print_seconds_per_cpu_second(compensator: Compensator, moved: Motion, dt: float) -> float:
    """The best of some passes over the stretches of a print."""
    stretches = np.split(moved.desired[:, :2], moved.begin[1:])
    weights = np.split(np.ones(len(moved.desired)), moved.begin[1:])
    best = np.inf
    for _ in range(REPEATS):
        began = time.process_time()
        for y_d, weight in zip(stretches, weights, strict=True):
            compensator.start(y_d[0]).push(y_d, weight, True)
        best = min(best, time.process_time() - began)
    return len(moved.desired) * dt / best


def row(name: str, printer: Printer, methods: tuple[str, ...], acceleration: float) -> str:
    """One plant."""
    settings = Settings(method="contour", acceleration=acceleration)
    moved = motion(PART.read_bytes(), printer, settings)
    cells = []
    for method in methods:
        began = time.process_time()
        compensator = Designs(printer, method, settings).compensator(0)
        designed = time.process_time() - began
        cells.append(f"{print_seconds_per_cpu_second(compensator, moved, settings.dt):.0f} ({designed:.2f} s)")
    return f"| {name} | {' | '.join(cells)} |"


def slow() -> str:
    """What a large design takes."""
    base = printer_of("35/28 Hz")
    x, y, z = base.axes
    began = time.process_time()
    made = Designs(replace(base, axes=(replace(x, model=SLOW), y, z)), "robust", Settings()).compensator(0)
    took = time.process_time() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / MB
    return f"{made.n_c} coefficients a window, knots every {made.basis.L} ms: {took:.1f} s of CPU, peak {peak:.0f} MB"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--acceleration", type=float, default=5000.0, help="of the plan [mm/s^2] (5000)")
    parser.add_argument("--limited", action="store_true", help="contour again, its commands held to limits")
    parser.add_argument("--slow", action="store_true", help="only a design that takes much memory")
    given = parser.parse_args()
    if given.slow:
        print(slow())
        return
    print(f"Print-seconds per CPU-second, and the time to design; at least {LEAST:.0f} are wanted.\n")
    print(f"| plant | {' | '.join(METHODS)} |\n|---|{'---|' * len(METHODS)}")
    for name in PLANTS:
        print(row(name, printer_of(name), METHODS, given.acceleration))
        if given.limited:
            x, y, z = printer_of(name).axes
            close = {"command_acceleration": CLOSE * given.acceleration}
            held = replace(printer_of(name), axes=(replace(x, **close), replace(y, **close), z))
            print(row(f"{name}, limited", held, ("contour",), given.acceleration))


if __name__ == "__main__":
    main()
