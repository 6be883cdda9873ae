"""Which prints are most like those that the numbers of robustness_reference.py were measured on.

    python benchmarks/robustness_parts.py --processes 2            36 ways to slice the three parts: 40 minutes of CPU
    python benchmarks/robustness_parts.py --processes 2 --write    puts the nearest of them into docs/robustness.md

How large those prints were, how fast, and how filled is not said, nor how one number is made of two signs. Here the
parts are sliced in many ways, and each is scored by what `none`, the shapers and `lpfbs` then have: the RMS of
ln(ratio) over their numbers, without `lpfbs` where the model is exact, where it depends on its knots. What `contour`
has is shown, and has no part in the score. Needs prusa-slicer on the path.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from executed import rms
from make_parts import JOBS, SPEEDS, sliced
from page import options, put
from robustness import ACCELERATIONS, CONDITIONS, PAGE, PARTS, SPREADS, Case, called, case, layers, mean
from robustness_reference import REFERENCE
from slicers import prusa_slicer

COMMAND = "benchmarks/robustness_parts.py --write"
SOLIDS = {part: JOBS[f"{part}.gcode"][0] for part in PARTS}
SIZES = (0.5, 0.75, 1.0)  # of the parts' width and length in sample_gcode/
PRINTED_AT = (100, 150, 200)  # mm/s
FILLS = {  # lines between the walls
    "at 45°": {}, "at 20°": {"fill_angle": "20"}, "along X and Y": {"fill_angle": "0"},
    "none": {"fill_density": "0%", "top_solid_layers": "0", "bottom_solid_layers": "0"},
}  # fmt: skip
OF_SIGNS: dict[str, Callable[[tuple[float, ...]], float]] = {"worse": max, "RMS": lambda pair: rms(np.array(pair))}
LEFT_OUT = ("70/56 Hz",)  # what is left of errors there is the chords'
JUDGED = called("contour", SPREADS[0])
ELSEWHERE = ("contour ±10 %", "robust ±15 %")  # robustness.py has them
SHOWN = 12
NEAR = 0.15


@dataclass(frozen=True)
class Way:
    """To slice: width and length, speed [mm/s], what is between the walls."""

    size: float
    speed: int
    fill: str


def layers_of(way: Way, part: str) -> bytes:
    """Every fourth layer of the part."""
    with tempfile.TemporaryDirectory() as scratch:
        gcode = Path(scratch) / f"{part}.gcode"
        settings = dict.fromkeys(SPEEDS, str(way.speed)) | FILLS[way.fill]
        sliced((SOLIDS[part], way.size, prusa_slicer, settings), gcode)
        return layers(gcode.read_bytes())


def printed(job: tuple[Way, str]) -> list[Case]:
    """A part sliced in a way, by every method that the reference has a number of."""
    way, part = job
    text = layers_of(way, part)
    found = []
    for plant, rows in REFERENCE.items():
        for method in rows:
            if plant not in LEFT_OUT and method not in ELSEWHERE:
                name, spread = ("contour", SPREADS[0]) if method == JUDGED else (method, None)
                found += [case(plant, part, text, a, name, spread) for a in ACCELERATIONS]
    return found


def ratios(found: list[Case], of: Callable[[tuple[float, ...]], float]) -> dict[tuple[str, str, str], float]:
    """By plant, method and condition, to the reference."""
    methods = {(c.plant, c.method) for c in found}
    return {(plant, method, condition): mean(found, plant, method, condition, of=of) / number
            for plant, rows in REFERENCE.items() for method, numbers in rows.items() if (plant, method) in methods
            for condition, number in zip(CONDITIONS, numbers, strict=True)}  # fmt: skip


def score(ratio: dict[tuple[str, str, str], float]) -> float:
    """RMS of ln(ratio) of the methods that are not judged here."""
    told = [np.log(r) for (_, method, condition), r in ratio.items()
            if method != JUDGED and (method, condition) != ("lpfbs", "exact")]  # fmt: skip
    return rms(np.array(told))


def table(ways: dict[Way, list[Case]]) -> str:
    """The ways that are most like the reference."""
    rows = []
    for way, found in ways.items():
        for name, of in OF_SIGNS.items():
            ratio = ratios(found, of)
            distance = score(ratio)
            own = {at: r for at, r in ratio.items() if at[1] == JUDGED}
            far = [f"{at[0]} {at[2]}: {r:.2f}" for at, r in own.items() if abs(r - 1.0) > NEAR]
            span = f"{min(own.values()):.2f} to {max(own.values()):.2f}"
            cells = (f"{way.size:g}", str(way.speed), way.fill, name, f"{distance:.3f}", span, "; ".join(far))
            rows.append((distance, f"| {' | '.join(cells)} |"))
    head = f"| size | mm/s | fill | of the signs | score | {JUDGED} | of it, not within {100 * NEAR:.0f} % |"
    return "\n".join([head, "|---" * 7 + "|", *(row for _, row in sorted(rows)[:SHOWN])])


def main() -> None:
    parser = options(__doc__, PAGE)
    parser.add_argument("--processes", type=int, default=1)
    wanted = parser.parse_args()
    ways = [Way(*each) for each in product(SIZES, PRINTED_AT, FILLS)]
    found: dict[Way, list[Case]] = {way: [] for way in ways}
    jobs = [(way, part) for way in ways for part in SOLIDS]
    with ProcessPoolExecutor(wanted.processes) as pool:
        for (way, part), cases in zip(jobs, pool.map(printed, jobs), strict=True):
            found[way] += cases
            sys.stderr.write(f"{way.size:g} {way.speed} mm/s, fill {way.fill}, {part}\n")
    text = table(found)
    print(text)
    if wanted.write:
        put(PAGE, COMMAND, text)


if __name__ == "__main__":
    main()
