"""How exact models must be for lpfbs to stay nearer to the path than contour: `python benchmarks/choice_rule.py`.

The evidence of EXACT in fbfcli/pipeline/choice.py. Two of the parts of robustness.py, printed and measured as there,
on machines whose frequencies are spread evenly over a range that contour is told: RMS error across the path over the
machines, geometric mean over the prints. (20 s of CPU.)
"""

from __future__ import annotations

import time

import numpy as np
from executed import Executed, executed, rms
from robustness import ACCELERATIONS, PLANTS, SLICED, TOLERANCE, UM, geometric, layers, machine, printer_of

from fbfcli.pipeline import Settings
from fbfcli.printer import Printer

PARTS = ("star", "curve")
HALF_RANGES = (0.01, 0.02, 0.03, 0.05)
MACHINES = 9  # each in the middle of its share of the range


def expected(done: Executed, printer: Printer, half: float, dt: float) -> float:
    """Error across the path of a machine that may be anywhere in the range, RMS [um]."""
    factors = 1.0 + half * ((2 * np.arange(MACHINES) + 1) / MACHINES - 1.0)
    errors = [UM * done.contour(done.nozzle(machine(printer, q, 1.0, dt))) for q in factors.tolist()]
    return rms(np.array(errors))


def row(plant: str) -> str:
    """lpfbs/contour by range."""
    printer = printer_of(plant)
    found: dict[tuple[str, float], list[float]] = {}
    for part in PARTS:
        text = layers((SLICED / f"{part}.gcode").read_bytes())
        for acceleration in ACCELERATIONS:
            plain = Settings(method="lpfbs", acceleration=acceleration, tolerance=TOLERANCE)
            lpfbs = executed(text, printer, plain)  # knows no range
            for half in HALF_RANGES:
                told = Settings(method="contour", acceleration=acceleration, tolerance=TOLERANCE, spread=half)
                contour = executed(text, printer, told)
                for name, done in (("lpfbs", lpfbs), ("contour", contour)):
                    found.setdefault((name, half), []).append(expected(done, printer, half, plain.dt))
    cells = ("/".join(f"{geometric(found[name, half]):.1f}" for name in ("lpfbs", "contour")) for half in HALF_RANGES)
    return f"| {plant} | {' | '.join(cells)} |"


def main() -> None:
    """Print the table."""
    began = time.process_time()
    print(f"lpfbs/contour, error across the path, RMS over {MACHINES} machines [um]\n")
    print(f"| x/y | {' | '.join(f'±{100 * half:.0f} %' for half in HALF_RANGES)} |")
    print("|---" * (1 + len(HALF_RANGES)) + "|")
    for plant in PLANTS:
        print(row(plant), flush=True)
    print(f"\n{time.process_time() - began:.0f} s of CPU")


if __name__ == "__main__":
    main()
