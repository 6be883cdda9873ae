"""Identify, compensate, and move the true machine: nearly as good as if the truth had been known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from part_cases import PART
from response_cases import FS, ONE, TWO, swept
from simulated_recordings import Response, Sensor, discrete, modal, recorded
from trajectory import motion

from fbfcli.cli.lookup import bundled
from fbfcli.pipeline import Settings
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.excite import excite
from fbfcli.pipeline.identify import identify_captures
from fbfcli.plant.excitation import Sweep
from fbfcli.plant.klipper_test import klipper_test
from fbfcli.plant.rational import profile_model
from fbfcli.plant.recording import Recording
from fbfcli.plant.sweep_spec import sweep_of_csv
from fbfcli.printer import ModalModel, Mode
from fbfcli.verify.contour_error import contour_error

SETTINGS = Settings(acceleration=5000.0)
MOST = 2.0  # times the error that the true model leaves


def identified(truth, axis, seed):
    """The model found in a recording of 5 % noise whose clock starts 3 ms late."""
    x, y = swept(truth, 0.05, np.random.default_rng(seed), f1=90.0)
    y = np.roll(y, round(3e-3 * FS))
    capture = Recording("pair", f"{axis}.csv", FS, np.arange(len(x)) / FS, y[:, None], (axis,), x, axis)
    return identify_captures([capture], Ask()).model


SENSOR = Sensor(fs=800.0, clock_error=3e-3, jitter=0.02, tilt=0.05, noise=0.05)


def captured(sweep: Sweep, truth: Response, axis: str, seed: int):
    """The model found in what an accelerometer saw of a test whose start nobody knows."""
    capture = recorded(sweep, truth, SENSOR, axis, np.random.default_rng(seed))
    return identify_captures([capture], Ask(axis=axis, sweep=sweep)).model


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


def test_so_it_is_from_what_klipper_writes():
    modes = Mode(34.0, 0.05, 0.7), Mode(58.0, 0.04, 0.3)
    bed = ModalModel((Mode(27.0, 0.08),))
    found = captured(klipper_test(f1=80.0), modal(modes), "x", 3)
    machine = with_models(ModalModel(modes), bed)
    assert error(with_models(found, bed), machine) < MOST * error(machine, machine)


def test_so_it_is_of_a_machine_with_zeros_outside_the_stable_region():
    """TAZ 6, by our own sweep; one axis stands for both, as in its profile."""
    machine = bundled()["taz6"]
    made = excite(bundled()["synthetic_bed_slinger"], "x", 5.0, 80.0, 4.0, ())
    sweep = sweep_of_csv(made.command.encode(), "sweep_x.csv")
    model = machine.axes[0].model
    found = captured(sweep, discrete(model.b, model.a, model.dt), "x", 4)
    x, y, z = machine.axes
    like = replace(machine, axes=(replace(x, model=found), replace(y, model=found), z))
    assert error(like, machine) < MOST * error(machine, machine)
