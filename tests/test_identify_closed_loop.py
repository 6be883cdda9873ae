"""Identify, compensate, and move the true machine: nearly as good as if the truth had been known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from part_cases import PART
from response_cases import FS, ONE, TWO, swept
from trajectory import motion

from fbfcli.cli.lookup import bundled
from fbfcli.pipeline import Settings
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.identify import identify_captures
from fbfcli.plant.rational import profile_model
from fbfcli.plant.recording import Recording
from fbfcli.verify.contour_error import contour_error

SETTINGS = Settings(acceleration=5000.0)
MOST = 2.0  # times the error that the true model leaves


def identified(truth, axis, seed):
    """The model found in a recording of 5 % noise whose clock starts 3 ms late."""
    x, y = swept(truth, 0.05, np.random.default_rng(seed), f1=90.0)
    y = np.roll(y, round(3e-3 * FS))
    capture = Recording("pair", f"{axis}.csv", FS, np.arange(len(x)) / FS, y[:, None], (axis,), x, axis)
    return identify_captures([capture], Ask()).model


def error(printer, machine):
    """RMS contour error [mm] of the part on a machine, compensated with a printer's models."""
    moved = motion(PART.encode(), printer, SETTINGS)
    nozzle = moved.nozzle(machine, SETTINGS)
    at = np.flatnonzero(moved.extruding)
    stretch = np.searchsorted(moved.begin, at, "right") - 1
    ends = np.append(moved.begin[1:], len(moved.desired)) - 1
    return np.sqrt(np.mean(contour_error(nozzle, moved.desired[:, :2], at, moved.begin[stretch], ends[stretch]) ** 2))


def with_models(x, y):
    printer = bundled()["synthetic_bed_slinger"]
    return replace(
        printer, axes=(replace(printer.axes[0], model=x), replace(printer.axes[1], model=y), printer.axes[2])
    )


def test_a_compensated_part_is_within_twice_the_true_model_s_error():
    machine = with_models(profile_model(TWO, 1e-3), profile_model(ONE, 1e-3))
    found = with_models(identified(TWO, "x", 1), identified(ONE, "y", 2))
    assert error(found, machine) < MOST * error(machine, machine)
