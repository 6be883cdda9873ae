"""How well the clock between a sensor and a sweep is found, on simulated recordings of known truth.

    python benchmarks/clock_truth.py [DRAWS]

Says a table: median and largest error [ppm] for each test, the lowest correlation, CPU seconds per recording.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from simulated_recordings import Response, discrete, drawn_sensor, modal, recorded

from fbfcli.cli.lookup import find_printer
from fbfcli.pipeline.excite import excite
from fbfcli.plant.alignment import paired
from fbfcli.plant.chirps import ulendo_sweep
from fbfcli.plant.excitation import Sweep
from fbfcli.plant.klipper_test import klipper_test, klipper_test_2020
from fbfcli.plant.sweep_spec import sweep_of_csv
from fbfcli.printer import Mode, TransferFunction

DRAWS = 6
PPM = 1e6


def own(name: str) -> Sweep:
    """The sweep that `fbf excite` writes for a bundled printer."""
    return sweep_of_csv(excite(find_printer(name), "x", 5.0, 130.0, 4.0, ()).command.encode(), f"{name}.csv")


def drawn_response(rng: np.random.Generator) -> Response:
    """One mode, two modes, or taz6."""
    kind, f = rng.integers(3), rng.uniform(25.0, 60.0)
    zeta = np.exp(rng.uniform(np.log(0.02), np.log(0.15), 2))
    if kind == 0:
        return modal([Mode(f, zeta[0])])
    if kind == 1:
        return modal([Mode(f, zeta[0], 0.7), Mode(f * rng.uniform(1.5, 2.2), zeta[1], 0.3)])
    model = find_printer("taz6").axes[0].model
    assert isinstance(model, TransferFunction)
    return discrete(model.b, model.a, model.dt)


def main(draws: int) -> None:
    """The table, on standard output."""
    sweeps = {
        "klipper": klipper_test(),
        "klipper without the slow wave": klipper_test(sweeping_period=0.0),
        "klipper-2020": klipper_test_2020(),
        "excite, synthetic_bed_slinger": own("synthetic_bed_slinger"),
        "excite, taz6": own("taz6"),
        "ulendo": ulendo_sweep(5.0, 80.0, 4.0, 4000.0, 0.05, 4000.0, 0.5, 1.0, 1.0),
    }
    print("| test | length [s] | clock: median, largest error [ppm] | correlation | CPU [s] |\n|---|---|---|---|---|")
    for name, sweep in sweeps.items():
        rng = np.random.default_rng(len(name))
        off, correlation, spent = [], [], 0.0
        for _ in range(draws):
            sensor = drawn_sensor(rng)
            recording = recorded(sweep, drawn_response(rng), sensor, "x", rng)
            began = time.process_time()
            pair = paired(recording, sweep, "x")
            spent += time.process_time() - began
            off.append(PPM * abs(pair.clock * (1 + sensor.clock_error) - 1))
            correlation.append(pair.correlation)
        print(f"| {name} | {sweep.duration:.0f} | {np.median(off):.1f}, {max(off):.1f} | {min(correlation):.3f} "
              f"| {spent / draws:.1f} |")  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else DRAWS)
