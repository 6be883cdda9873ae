"""`fbf excite` from outside: files, what it says, and the G-code executed by the planner's model."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from part_cases import one_line

from fbfcli.cli import main
from fbfcli.cli.lookup import bundled_files, find_printer
from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.scan import scan
from fbfcli.motion.planner import Planner
from fbfcli.motion.sample import sample
from fbfcli.plant.excitation import acceleration
from fbfcli.plant.sweep_spec import sweep_of_csv

pytestmark = pytest.mark.usefixtures("nobody")
DT = 1e-4
FBF = [sys.executable, "-m", "fbfcli.cli.main"]


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run(*words: object) -> int:
    return main.run(["excite", *map(str, words)])


def executed(text: bytes, name: str, axis: str):
    """Positions [mm] of the axis every DT as the planner's model executes a file, from its first swing on."""
    printer = find_printer(name)
    block, _ = interpret(scan(text), initial_state(printer), printer)
    parts = list(Planner(printer.firmware).feed(block.moves, np.zeros(len(block.moves), dtype=bool), last=True))
    begin = text.split(b"\n").index(b"; swings begin")
    x, t0 = [], 0.0
    for part in parts:
        inside = part.moves.line > begin
        moves, timing = part.moves[inside], part.profile[inside]
        start = t0 + np.concatenate([[0.0], np.cumsum(timing.duration)[:-1]])
        x.append((moves, timing, start))
        t0 += float(timing.duration.sum())
    at = [sample(m.start, m.delta, m.distance, p, s, int(t0 / DT) + 1, DT)[0][:, "xy".index(axis)] for m, p, s in x]
    assert len(at) == 1
    return at[0]


@pytest.mark.parametrize("name", sorted(bundled_files()))
@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_file_executed_gives_the_csv(name, axis):
    """Second differences of the executed positions against the CSV's mean accelerations, all of 0.1 ms."""
    assert run("-p", name, "--axis", axis, "--to", 60, "--accel", 1500, "--accel", 2500, "--rate", 8) == 0
    with open(f"sweep_{axis}.gcode", "rb") as file:
        x = executed(file.read(), name, axis)
    with open(f"sweep_{axis}.csv", "rb") as file:
        sweep = sweep_of_csv(file.read(), "command")
    assert sweep.duration == pytest.approx(len(x) * DT, abs=2 * DT)
    t = np.arange(1, len(x) - 1) * DT
    velocity = np.diff(x) / DT
    told = sweep.velocity(t + 0.5 * DT) - sweep.velocity(t - 0.5 * DT)
    off = np.diff(velocity) - told
    at_once = find_printer(name).firmware != "klipper"  # it turns from 0.05 to -0.05 mm/s in no time
    assert np.sqrt(np.mean(off**2)) < 0.02 * np.sqrt(np.mean(told**2)) + 0.02 * at_once
    first, last = sweep.segments[0][:2], sweep.segments[1][:2]
    for (begin, end), size in ((first, 1500.0), (last, 2500.0)):
        inside = np.arange(begin + 0.1, end - 0.1, 1e-3)
        assert np.sqrt(np.mean(acceleration(sweep, inside, 1e-4) ** 2)) == pytest.approx(size, rel=0.03)


@pytest.mark.parametrize("name", sorted(bundled_files()))
def test_it_stays_on_the_bed_and_within_the_limits(name):
    assert run("-p", name, "--axis", "x") == 0
    printer = find_printer(name)
    with open("sweep_x.gcode", "rb") as file:
        x = executed(file.read(), name, "x")
    low, high = printer.axes[0].travel
    assert low < x.min() and x.max() < high
    assert abs(0.5 * (x.min() + x.max()) - 0.5 * (low + high)) < 1.0
    fastest = min(printer.limits.velocity, printer.limits.axis_velocity[0])
    assert np.abs(np.diff(x)).max() / DT <= fastest
    ceiling = min(printer.limits.acceleration, printer.limits.axis_acceleration[0])
    with open("sweep_x.csv", encoding="utf-8") as file:
        rows = [line for line in file if line[0].isdigit()]
    assert max(abs(float(row.split(",")[1])) for row in rows) <= ceiling + 1e-6


@pytest.mark.parametrize("name", sorted(bundled_files()))
def test_the_limits_are_put_back(name):
    run("-p", name, "--axis", "y", "-q")
    printer = find_printer(name)
    with open("sweep_y.gcode", "rb") as file:
        _, state = interpret(scan(file.read()), initial_state(printer), printer)
    assert state.limits[state.in_force] == printer.limits


def test_files_and_words(capsys):
    assert run("-p", "taz6", "--axis", "x", "--json", "told.json") == 0
    assert sorted(os.listdir()) == ["sweep_x.csv", "sweep_x.gcode", "told.json"]
    said = capsys.readouterr()
    assert not said.out and "up to" not in said.out and "sweeps:" in said.err
    with open("told.json", encoding="utf-8") as file:
        told = json.load(file)
    assert told["axis"] == "x" and told["duration"] > 10 and len(told["sweeps"]) == 2
    assert run("-p", "taz6", "--axis", "x", "-q", "-o", "other.g") == 0
    assert "other.csv" in os.listdir() and not capsys.readouterr().err


def test_to_standard_output():
    done = subprocess.run([*FBF, "excite", "-p", "taz6", "--axis", "x", "-o", "-"], capture_output=True, timeout=60)
    assert done.returncode == 0 and done.stdout.startswith(b"; fbf ") and b"sweeps:" in done.stderr
    assert os.listdir() == []
    csv = subprocess.run([*FBF, "excite", "-p", "taz6", "--axis", "x", "-q", "-o", "x.g", "--csv", "-"],
                         capture_output=True, timeout=60)  # fmt: skip
    assert csv.returncode == 0 and b"time_s,accel_cmd_x" in csv.stdout and os.listdir() == ["x.g"]


@pytest.mark.parametrize(("words", "told"), [
    (["-p", "taz6", "--axis", "x", "--accel", "50000"], "taz6.toml: --accel 50000.* allows 9000"),
    (["-p", "nobody", "--axis", "x"], "no printer"),
    (["--axis", "x"], "no printer"),
    (["-p", "taz6", "--axis", "x", "-o", "there/x.gcode"], "there is no folder there"),
    (["-p", "taz6", "--axis", "x", "--accel", "200", "--from", "20"], "can be swept"),
])  # fmt: skip
def test_what_cannot_be_is_one_line(words, told, capsys):
    assert run(*words) == 1
    assert re.search(told, one_line(capsys))
    assert os.listdir() == []


def test_a_printer_that_nobody_has_measured_yet(tmp_path):
    text = bundled_files()["synthetic_bed_slinger"].read_text()
    without = re.sub(r"\[axis\.[xy]\.model\]\nmodes.*\n", "", text)
    assert "modes" not in without
    (tmp_path / "new.toml").write_text(without)
    assert run("-p", "new.toml", "--axis", "x") == 0


def test_a_bed_that_is_too_small(tmp_path, capsys):
    text = bundled_files()["taz6"].read_text().replace("travel = [-20.0, 300.0]", "travel = [0.0, 18.0]")
    (tmp_path / "small.toml").write_text(text)
    assert run("-p", "small.toml", "--axis", "x") == 1
    assert "whose travel is 18 mm" in one_line(capsys)
    assert os.listdir() == ["small.toml"]


@pytest.mark.parametrize("words", [["-p", "taz6"], ["-p", "taz6", "--axis", "z"],
                                   ["-p", "taz6", "--axis", "x", "--to", "6"],
                                   ["-p", "taz6", "--axis", "x", "-o", "-", "--json", "-"],
                                   ["-p", "taz6", "--axis", "x", "-o", "a.csv"],
                                   ["-p", "taz6", "--axis", "x", "--rate", "nan"]])  # fmt: skip
def test_a_wrong_command_line(words, capsys):
    assert run(*words) == 2
    assert os.listdir() == []


def test_a_full_disk_leaves_nothing_behind():
    def small():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = subprocess.run([*FBF, "excite", "-p", "taz6", "--axis", "x"], capture_output=True, preexec_fn=small,
                          timeout=60)  # fmt: skip
    assert done.returncode == 1 and b"cannot be written" in done.stderr and done.stderr.count(b"\n") == 1
    assert os.listdir() == []


def test_it_is_quick():
    began = time.process_time()
    run("-p", "synthetic_bed_slinger", "--axis", "x")
    assert time.process_time() - began < 3.0
