"""Identify machines whose truth is known, and say how far off the answers are.

    python benchmarks/identify_truth.py                 50 draws of each kind: some 20 minutes of CPU
    python benchmarks/identify_truth.py --draws 5 --processes 2
    python benchmarks/identify_truth.py --first 500     other draws
    python benchmarks/identify_truth.py --write         puts the table into docs/identify.md

Each draw: a plant, a sensor (3.9 mg steps, clock off by up to 0.5 %, jitter, tilt, gravity, 5 % noise) and an unknown
start. Known are the test, and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
from page import options, put
from simulated_recordings import Response, discrete, drawn_sensor, modal, recorded

from fbfcli.cli.lookup import bundled
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.excite import excite
from fbfcli.pipeline.identified import Identified
from fbfcli.pipeline.identify import identify_captures
from fbfcli.plant.excitation import Sweep
from fbfcli.plant.klipper_test import klipper_test
from fbfcli.plant.model import modes, plant_of
from fbfcli.plant.rational import response
from fbfcli.plant.sweep_spec import sweep_of_csv
from fbfcli.printer import Mode, TransferFunction

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "identify.md"
COMMAND = "benchmarks/identify_truth.py --write"
HEAD = (
    "| test | plant | draws | frequency, worst | damping, worst | lines of coherence > 0.9 within 5 % and 5° | "
    "model on these lines, worst | delay of the model, worst | frequency in its 95 % interval | damping in its |"
)
DRAWS, FIRST = 50, 5000  # seeds below were looked at while the method was made
COHERENT = 0.9
FREQUENCY, DAMPING = (20.0, 80.0), (0.02, 0.15)  # that modes are drawn from
HIGHER = (1.4, 2.2)  # the second mode's frequency by the first's
SHARE = (0.55, 0.85)  # the first mode's gain


@dataclass(frozen=True)
class Truth:
    """A plant: modes (frequency [Hz], damping), and its response as the simulation takes it."""

    modes: tuple[tuple[float, float], ...]
    response: Response


@dataclass(frozen=True)
class Score:
    """One draw.

    frequency, damping : errors of each mode [1];  held: whether its 95 % intervals hold the truth
    magnitude, phase   : largest errors [1], [deg] of the response where the coherence is above 0.9; then the model's
    within, lines      : how many of these lines are within 5 % and 5 deg, and how many there are
    delay              : of the model against the truth [s], taken out of the phases: an unknown start hides it
    """

    frequency: tuple[float, ...]
    damping: tuple[float, ...]
    held: tuple[bool, ...]
    magnitude: float
    phase: float
    model_magnitude: float
    model_phase: float
    within: int
    lines: int
    delay: float


def one_mode(rng: np.random.Generator) -> Truth:
    """A mode drawn evenly in frequency and in the logarithm of damping."""
    return _modal([Mode(rng.uniform(*FREQUENCY), _damping(rng))])


def two_modes(rng: np.random.Generator) -> Truth:
    """A second, weaker mode above the first."""
    f, share = rng.uniform(*FREQUENCY) / 1.4, rng.uniform(*SHARE)
    f = max(f, FREQUENCY[0])
    return _modal([Mode(f, _damping(rng), share), Mode(f * rng.uniform(*HIGHER), _damping(rng), 1 - share)])


def taz6(rng: np.random.Generator) -> Truth:
    """The published model: two modes, a lag, and zeros outside the stable region."""
    model = bundled()["taz6"].axes[0].model
    assert isinstance(model, TransferFunction)
    found = sorted((mode.frequency, mode.damping) for mode in modes(plant_of(model, model.dt, "X")))
    return Truth(tuple(found), discrete(model.b, model.a, model.dt))


PLANTS = {"one mode": one_mode, "two modes": two_modes, "TAZ 6": taz6}


@cache
def sweeps() -> dict[str, Sweep]:
    """Klipper's test, and ours for a printer that allows it."""
    made = excite(bundled()["synthetic_bed_slinger"], "x", 5.0, 130.0, 4.0, ())
    return {"Klipper": klipper_test(), "fbf excite": sweep_of_csv(made.command.encode(), "sweep_x.csv")}


def score(truth: Truth, found: Identified) -> Score:
    """How far off one answer is."""
    frequency, damping, held = [], [], []
    for f, zeta in truth.modes:
        near = min(found.modes, key=lambda mode: abs(np.log(mode.frequency.value / f)))
        frequency.append(near.frequency.value / f - 1)
        damping.append(near.damping.value / zeta - 1)
        held += [near.frequency.low <= f <= near.frequency.high, near.damping.low <= zeta <= near.damping.high]
    assert found.measured is not None
    frf, theta = found.measured.frf, found.measured.candidates[0].theta
    H = truth.response(frf.frequency)
    outside = np.exp(theta[0] - 2j * np.pi * frf.frequency * (theta[1] + theta[2] * frf.frequency))
    seen = frf.coherence > COHERENT
    fitted = response(found.rational, frf.frequency) / H
    delay = pure_delay(fitted[seen], frf.frequency[seen])
    measured, fitted = ((r * np.exp(2j * np.pi * frf.frequency * delay))[seen] for r in (frf.H / outside / H, fitted))
    off = [(np.abs(np.abs(r) - 1), np.abs(np.degrees(np.angle(r)))) for r in (measured, fitted)]
    good = (off[0][0] < 0.05) & (off[0][1] < 5)
    return Score(tuple(frequency), tuple(damping), tuple(held), float(off[0][0].max()), float(off[0][1].max()),
                 float(off[1][0].max()), float(off[1][1].max()), int(good.sum()), len(good),
                 delay)  # fmt: skip


def pure_delay(ratio: np.ndarray, f: np.ndarray) -> float:
    """Seconds by which phases of `ratio`, falling in proportion to f, come late."""
    return float(-(f @ np.unwrap(np.angle(ratio))) / (f @ f) / (2 * np.pi))


def drawn(kind: str, plant: str, sweep: Sweep, seed: int) -> tuple[Truth, Identified]:
    """The truth and what was identified of one draw."""
    rng = np.random.default_rng([seed, *map(ord, kind + plant)])
    truth = PLANTS[plant](rng)
    capture = recorded(sweep, truth.response, drawn_sensor(rng), "x", rng)
    return truth, identify_captures([capture], Ask(axis="x", sweep=sweep))


def scored(kind: str, plant: str, seed: int) -> Score:
    """One draw, from the truth to its score. Another process makes its own sweeps: they hold functions."""
    return score(*drawn(kind, plant, sweeps()[kind], seed))


def row(kind: str, plant: str, scores: Sequence[Score]) -> str:
    """One line of the table: the worst of all draws, and how many of all modes' intervals hold the truth."""
    frequency = np.abs([f for s in scores for f in s.frequency])
    damping = np.abs([d for s in scores for d in s.damping])
    held = np.array([s.held for s in scores]).reshape(-1, 2)
    cells = (
        kind, plant, str(len(scores)),
        f"{100 * frequency.max():.3f} %", f"{100 * damping.max():.2f} %",
        f"{sum(s.within for s in scores)} of {sum(s.lines for s in scores)}",
        f"{100 * max(s.model_magnitude for s in scores):.1f} %, {max(s.model_phase for s in scores):.1f}°",
        f"{1e3 * max(abs(s.delay) for s in scores):.2f} ms",
        *(f"{count} of {len(held)}" for count in held.sum(axis=0)),
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _modal(truth: list[Mode]) -> Truth:
    return Truth(tuple((mode.frequency, mode.damping) for mode in truth), modal(truth))


def _damping(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(DAMPING))))


def main() -> None:
    parser = options(__doc__, PAGE)
    parser.add_argument("--draws", type=int, default=DRAWS)
    parser.add_argument("--test", action="append", choices=["Klipper", "fbf excite"], help="only this one")
    parser.add_argument("--first", type=int, default=FIRST, help="seed of the first draw")
    parser.add_argument("--processes", type=int, default=1)
    wanted = parser.parse_args()
    seeds = range(wanted.first, wanted.first + wanted.draws)
    lines = [HEAD, "|---" * HEAD.count(" | ") + "|---|"]
    print("\n".join(lines), flush=True)
    with ProcessPoolExecutor(wanted.processes) as pool:
        for kind in sweeps():
            if wanted.test and kind not in wanted.test:
                continue
            for plant in PLANTS:
                scores = list(pool.map(partial(scored, kind, plant), seeds))
                lines.append(row(kind, plant, scores))
                print(lines[-1], flush=True)
    if wanted.write:
        put(PAGE, COMMAND, "\n".join(lines))


if __name__ == "__main__":
    main()
