"""`fbf steps` as people and pipes use it."""

from __future__ import annotations

import json
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from part_cases import FBF, PART, ROOT, names, one_line

from fbfcli.cli import main
from fbfcli.cli.npz_archive import read_npz
from fbfcli.steps.compact import read_compact
from fbfcli.steps.csv_steps import read_csv
from fbfcli.steps.pages import read_pages
from fbfcli.steps.positions import read_positions
from fbfcli.steps.vcd import read_vcd

pytestmark = pytest.mark.usefixtures("nobody")

SIGROK = shutil.which("sigrok-cli")
# without its motors, which would have to suit every other machine that is made of it
PROFILE = re.sub(r"\[axis\.[xy]\.(motor|load)\]\n([^\[\n].*\n)*\n", "",
                 (ROOT / "configs" / "synthetic_bed_slinger.toml").read_text())  # fmt: skip
END = (80 * 20, 80 * 20, 400)  # of PART, in steps


def run(*words: object) -> int:
    return main.run(["steps", "-p", "synthetic_bed_slinger", "-m", "mzv", *map(str, words)])


def start(*words: object, **how) -> subprocess.Popen:
    command = [*FBF, "steps", "-p", "synthetic_bed_slinger", "-m", "mzv", *map(str, words)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how)


def test_the_stream_stands_beside_the_file_with_its_events(part):
    assert run(part, "-q") == 0
    assert names(part) == ["my part.csv", "my part.csv.events.jsonl", "my part.gcode"]
    steps = read_csv(part.with_suffix(".csv").read_bytes())
    assert tuple(steps[name].moved for name in "xyz") == END
    events = [json.loads(line) for line in part.with_name("my part.csv.events.jsonl").read_text().splitlines()]
    assert [event["text"] for event in events] == ["M73 P0 R99", "G28", "M73 P50 R44", "M73 P100 R0"]
    first = PART.splitlines().index("M73 P50 R44") + 1
    assert [event["line"] for event in events][2] == first


@pytest.mark.parametrize(("ending", "reader"), [
    (".csv", read_csv), (".npz", read_npz), (".steps", read_compact), (".vcd", read_vcd), (".g6", read_pages),
], ids=lambda value: value if isinstance(value, str) else "")  # fmt: skip
def test_the_ending_of_a_name_is_its_format(part, ending, reader):
    out = part.with_name("out" + ending)
    assert run(part, "-q", "-o", out) == 0
    assert tuple(reader(out.read_bytes())[name].moved for name in "xyz") == END


def test_positions_end_where_the_file_ends(part):
    assert run(part, "-q", "-t", "positions", "--rate", 500) == 0
    assert read_positions(part.with_suffix(".txt").read_bytes())[-1].tolist()[:3] == [20.0, 20.0, 1.0]


def test_from_a_pipe_to_a_pipe(part):
    out, told = start("-t", "compact", "--events", part.with_name("events")).communicate(PART.encode())
    assert tuple(read_compact(out)[name].moved for name in "xyz") == END
    assert b"motor x" in told
    assert names(part) == ["events", "my part.gcode"]


@pytest.mark.parametrize("name", ["csv", "npz", "compact", "vcd", "positions", "marlin"])
def test_a_pipe_gets_what_a_file_gets(part, name):
    assert run(part, "-q", "-t", name, "-o", part.with_name("out")) == 0
    process = start(part, "-q", "-t", name, "-o", "-")
    assert process.communicate()[0] == part.with_name("out").read_bytes()


def test_the_summary_for_scripts(part, capsys):
    assert run(part, "-n", "--json", "-", "-t", "vcd") == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert names(part) == [part.name]
    assert told["format"] == "vcd"
    assert told["bytes"] > 20 * sum(motor["steps"] for motor in told["motors"]) / 2
    assert tuple(motor["end"] for motor in told["motors"][:3]) == END
    assert {"printer", "kinematics", "method", "time", "lines", "moves", "events", "warnings"} <= told.keys()
    assert "motor x" in said.err
    assert "per step" in said.err


def test_quiet_is_quiet(part, capsys):
    assert run(part, "-q") == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "")


def test_a_compensated_file_is_taken_as_it_is_written(part, capsys):
    assert main.run(["compensate", "-p", "synthetic_bed_slinger", "-m", "mzv", "-q", str(part)]) == 0
    ready = part.with_name("my part.fbf.gcode")
    assert run(ready, "-m", "auto", "--json", "-") == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["method"] == "none"
    assert "compensated already, taken as it is written" in said.err
    assert tuple(motor["end"] for motor in json.loads(said.out)["motors"][:3]) == END
    for words, option in (["-m", "auto", "--accel", 1000], "--accel"), (["-m", "lpfbs"], "--method"):
        assert run(ready, *words) == 2
        assert f"no {option}" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "told"), [
    (["--rate", "100"], "--rate is for"),
    (["-t", "vdc"], "vdc"),
    (["-m", "fbf", "--preview", "100"], "--preview is for"),
    (["--json", "-", "-o", "-"], "only one of"),
    (["--events", "-", "-o", "-"], "only one of"),
    (["--fromat", "csv"], "--format"),
])  # fmt: skip
def test_a_wrong_command_line(part, capsys, words, told):
    assert run(part, *words) == 2
    assert told in capsys.readouterr().err
    assert names(part) == [part.name]


@pytest.mark.parametrize("method", ["none", "mzv"])
def test_no_more_than_the_machine_stands(part, capsys, method):
    assert run(part, "-m", method, "--accel", 1e6) == 1
    assert "more than the machine stands" in one_line(capsys)
    assert names(part) == [part.name]


def test_the_stream_cannot_replace_its_file(part, capsys):
    assert run(part, "-o", part) == 2
    assert "FILE itself" in capsys.readouterr().err
    assert part.read_text() == PART


@pytest.mark.parametrize(("old", "new", "told"), [
    ("steps_per_mm = 80.0", "steps_per_mm = 0", "axis.x.steps_per_mm = 0: must be greater than 0"),
    ("steps_per_mm = 80.0", "steps_per_mm = -80", "axis.x.steps_per_mm = -80: must be greater than 0"),
    ("steps_per_mm = 80.0", "steps_per_mm = 8000", "line 9: at .* motor x would make .* max_step_rate"),
    ('"cartesian"', '"delta"', "delta_radius and arm_length"),
    ('"cartesian"', '"delta"\ndelta_radius = 90\narm_length = 100', "line 9: .* out of the arms' reach"),
    ('"cartesian"', '"delta"\ndelta_radius = 90\narm_length = 80', "arm_length = 80: is not longer than"),
    ("[limits]", "[driver]\nmax_step_rate = 1e6\n[limits]", "driver.max_step_rate .* no room for a pulse"),
    ("[limits]", "[driver]\nmax_steprate = 1\n[limits]", "did you mean max_step_rate"),
    ("[limits]", "[driver]\nhysteresis = -1\n[limits]", "driver.hysteresis = -1"),
])  # fmt: skip
def test_a_bad_machine_is_refused_in_one_line(part, capsys, tmp_path, old, new, told):
    assert old in PROFILE
    (tmp_path / "mine.toml").write_text(PROFILE.replace(old, new, 1))
    assert main.run(["steps", "-m", "mzv", "-p", str(tmp_path / "mine.toml"), str(part)]) == 1
    assert re.search(told, one_line(capsys))
    assert names(part) == [part.name]


@pytest.mark.parametrize(("bad", "told"), [
    ("", "empty"), ("G28\nG1 X10 Y10 F3000\nG1 Xnan Y5\n", ":3:"), ("G28\nG1 X10 Y10 F3000\nG1 X900\n", "travel"),
], ids=["empty", "nan", "outside"])  # fmt: skip
@pytest.mark.parametrize("name", ["csv", "npz"])
def test_a_bad_file_is_refused_in_one_line(part, capsys, bad, told, name):
    part.write_text(bad)
    assert run(part, "-t", name) == 1
    assert told in one_line(capsys)
    assert names(part) == [part.name]


@pytest.mark.parametrize("name", ["csv", "npz", "compact", "vcd", "positions", "marlin"])
def test_a_file_that_does_not_move_is_an_empty_stream(part, name):
    part.write_text("; nothing but a comment\nM104 S200\n")
    assert run(part, "-q", "-t", name, "-o", part.with_name("out")) == 0
    assert '"M104 S200"' in part.with_name("out.events.jsonl").read_text()


def test_more_steps_than_a_page_takes(part, capsys):
    assert run(part, "-t", "marlin", "--rate", 3000) == 1
    assert "give a higher --rate than 3000" in one_line(capsys)
    assert names(part) == [part.name]


def test_a_full_disk_leaves_nothing_behind(part):
    def small() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    process = start(part, preexec_fn=small)
    _, told = process.communicate()
    assert process.returncode == 1
    assert told.count(b"\n") == 1
    assert b"File too large" in told
    assert names(part) == [part.name]


def test_ctrl_c_leaves_nothing_behind(part):
    part.write_text(PART + "G1 X30 Y30\nG1 X40 Y30\n" * 400_000)
    process = start(part, "-q")
    while process.poll() is None and len(names(part)) < 2:
        time.sleep(0.05)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told == b"fbf: interrupted\n"
    assert names(part) == [part.name]


def test_a_reader_that_goes_away_ends_it_quietly(part):
    part.write_text(PART + "G1 X30 Y30\nG1 X40 Y30\n" * 2000)
    process = start(part, "-q", "-o", "-")
    process.stdout.read(100)
    process.stdout.close()
    told = process.stderr.read()
    assert process.wait(60) == 141
    assert told == b""


def test_help_names_the_verb_and_its_formats(capsys):
    assert main.run(["steps", "--help"]) == 0
    said = capsys.readouterr().out
    for word in ("--format", "vcd", "halstreamer", "--events"):
        assert word in said


@pytest.mark.skipif(not SIGROK, reason="sigrok-cli is not installed")
def test_a_logic_analysers_software_sees_the_same_steps(part):
    """sigrok reads the dump sample by sample, and what it writes of that again holds the same steps."""
    out, again = part.with_name("out.vcd"), part.with_name("again.vcd")
    assert run(part, "-q", "-o", out) == 0
    shown = subprocess.run([SIGROK, "-i", out, "-I", "vcd", "--show"], capture_output=True, text=True, check=True)
    assert "Samplerate: 1000000" in shown.stdout
    assert all(f"{name}_{kind}: logic" in shown.stdout for name in "xyz" for kind in ("step", "dir"))
    subprocess.run([SIGROK, "-i", out, "-I", "vcd", "-O", "vcd", "-o", again], check=True, capture_output=True)
    first, second = read_vcd(out.read_bytes()), read_vcd(again.read_bytes())
    assert first.keys() == second.keys()
    for name, steps in first.items():
        assert (steps.time == second[name].time).all()
        assert (steps.forward == second[name].forward).all()


def test_numpy_is_not_needed_to_ask_for_help():
    code = "import sys; from fbfcli.cli import main; main.run(['steps', '--help']); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_npz_opens_with_numpy_alone(part):
    assert run(part, "-q", "-t", "npz") == 0
    with np.load(part.with_suffix(".npz")) as arrays:
        assert arrays["x_time"].dtype == np.int64
        assert arrays["x_forward"].dtype == bool
