"""`fbf simulate` from outside: what it says, what it writes, and what it refuses."""

from __future__ import annotations

import csv
import io
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from part_cases import COMPENSATE, FBF, PART, names, one_line

from fbfcli.cli import main
from fbfcli.cli.method_options import METHODS
from fbfcli.pipeline.simulate import Wanted

pytestmark = pytest.mark.usefixtures("nobody")

PRINTER = ("-p", "synthetic_bed_slinger")
SIMULATE = [*FBF, "simulate", *PRINTER]


def run(*words: object) -> int:
    return main.run(["simulate", *PRINTER, *map(str, words)])


def figures(part: Path, *words: object) -> dict:
    told = part.with_name("figures.json")
    assert run(part, "-q", "--json", told, *words) == 0
    read = json.loads(told.read_text())
    told.unlink()
    return read


def test_before_and_after_are_told_and_nothing_is_written(part, capsys):
    assert run(part) == 0
    said = capsys.readouterr()
    assert not said.out and names(part) == [part.name] and part.read_text() == PART
    table = said.err.splitlines()
    assert table[0].startswith("errors in um") and "contour rms" in table[0]
    assert table[1].startswith("none ") and table[2].startswith("auto ")
    assert "contour; the profile does not say" in said.err


def test_json_is_the_same_in_a_file_and_on_standard_output(part, capsys):
    in_file = figures(part, "-m", "none,zv", "--mismatch", "10%", "--accel", "1000,4000")
    capsys.readouterr()
    assert run(part, "-m", "none,zv", "--mismatch", 10, "--accel", "1000,4000", "--json", "-", "-q") == 0
    assert json.loads(capsys.readouterr().out) == in_file
    assert [(one["name"], one["acceleration"]) for one in in_file["results"]] == [
        ("none", 1000.0), ("zv", 1000.0), ("none", 4000.0), ("zv", 4000.0)
    ]  # fmt: skip
    for one in in_file["results"]:
        assert set(one["conditions"]) == {condition["name"] for condition in in_file["conditions"]}
        assert len(one["conditions"]) == 5
    assert in_file["results"][1]["made_for"][0]["frequency"] == pytest.approx(35.0, rel=0.1)


def test_a_pipe_is_simulated_as_the_file_is(part):
    with part.open("rb") as stdin:
        piped = subprocess.run([*SIMULATE, "-q", "--json", "-"], stdin=stdin, capture_output=True, timeout=60)
    named = subprocess.run([*SIMULATE, "-q", "--json", "-", str(part)], capture_output=True, timeout=60)
    assert piped.returncode == named.returncode == 0
    assert piped.stdout == named.stdout and not piped.stderr


def test_csv_is_where_the_nozzle_goes(part):
    out = part.with_name("path.csv")
    told = figures(part, "-m", "none,zv", "--csv", out, "--rate", 2000)
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert {row["method"] for row in rows} == {"none", "zv"}
    lines = PART.splitlines()
    for one in told["results"]:
        mine = [row for row in rows if row["method"] == one["name"]]
        printing = [row for row in mine if row["extruding"] == "1"]
        assert all("E2" in lines[int(row["line"]) - 1] for row in printing)
        assert len(printing) / 2000 == pytest.approx(one["conditions"]["as modelled"]["extruding"])
        worst = max(float(row["contour_um"]) for row in printing)
        assert worst == pytest.approx(one["conditions"]["as modelled"]["total"]["contour"]["max"], abs=1e-3)
        assert [float(mine[-1][f"desired_{axis}"]) for axis in "xy"] == [20.0, 20.0]


def test_a_feature_that_comes_late_in_a_file_is_in_the_csv(part):
    far_apart = f";{'x' * (1 << 19)}\n"  # more than is read at once
    there_and_back = "G1 X20.5 Y20 E.1 F9000\nG1 X20 Y20.5 E.1\n" * 1000
    late = ';TYPE:Bridge, "late"\nG1 X20 Y20 E.1\n'
    part.write_text(f"{PART}M83\n;TYPE:Perimeter\n{there_and_back}{far_apart}{late}")
    out = part.with_name("path.csv")
    assert run(part, "-q", "-m", "none", "--csv", out) == 0
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert [rows[k]["feature"] for k in (0, len(rows) // 2, -1)] == ["unknown", "Perimeter", 'Bridge, "late"']


def test_a_compensated_file_is_executed_as_it_is_written(part, capsys):
    subprocess.run([*COMPENSATE, "-q", str(part)], check=True, timeout=60)
    written = part.with_name("my part.fbf.gcode")
    assert run(written) == 0
    said = capsys.readouterr().err
    assert "is compensated already, executed as it is written" in said and "written path" in said
    assert "as written " in said and "none " not in said and "auto " not in said
    for words in (("-m", "zv"), ("--accel", "1000"), ("--velocity", "50"), ("--firmware-shaper", "zv")):
        assert run(written, *words) == 2
        assert "simulate the original" in capsys.readouterr().err


def test_another_machine_may_draw(part):
    same, other = figures(part), figures(part, "--plant", "taz6")
    assert (same["machine"], other["machine"]) == ("Synthetic bed slinger", "LulzBot TAZ 6")
    rms = [told["results"][0]["conditions"]["as modelled"]["total"]["contour"]["rms"] for told in (same, other)]
    assert rms[0] != rms[1]


def test_ten_thousand_samples_a_second_of_a_machine_that_rings_long(part):
    slow, fast = (figures(part, "-m", "none", "--mismatch", 10, "--rate", rate) for rate in (1000, 10_000))
    for a, b in zip(*(told["results"][0]["conditions"].values() for told in (slow, fast)), strict=True):
        assert a["total"]["contour"]["rms"] == pytest.approx(b["total"]["contour"]["rms"], rel=0.02)


def test_shapers_in_the_firmware_stand_beside_the_methods(part, capsys):
    assert run(part, "-m", "none", "--firmware-shaper", "mzv,ei") == 0
    said = capsys.readouterr().err
    assert "firmware mzv " in said and "firmware ei:   made for x 4" in said


def test_quiet_is_silent(part, capsys):
    assert run(part, "-q") == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(("words", "told"), [
    (("-m", "none,magic"), "'magic' is not one of auto, none"),
    (("-m", ""), "is not one of"),
    (("--firmware-shaper", "zvd"), "'zvd' is not one of zv, mzv"),
    (("--accel", "1000,nan"), "not a finite number"),
    (("--accel", "1000,0"), "not in the range"),
    (("--accel", "fast"), "not a valid float"),
    (("--mismatch", "0"), "not in the range"),
    (("--mismatch", "60"), "not in the range"),
    (("--rate", "1500"), "whole thousands"),
    (("--rate", "500"), "not in the range"),
    (("--csv", "-", "--json", "-"), "two things would go to standard output"),
    (("--cvs", "x"), "No such option"),
])  # fmt: skip
def test_a_wrong_command_line_is_told(part, capsys, words, told):
    assert run(part, *words) == 2
    assert told in capsys.readouterr().err
    assert names(part) == [part.name]


@pytest.mark.parametrize(("bad", "told"), [
    (b"", ["empty"]),
    (b"\x7fELF\0\0\1", ["binary"]),
    (b"GCDE\1\0\0\0", ["binary G-code", "PrusaSlicer"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 Xnan Y5\n", [":3:", "G1 Xnan Y5"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 X900\n", [":3:", "X900", "travel"]),
], ids=["empty", "binary", "bgcode", "nan", "outside"])  # fmt: skip
@pytest.mark.parametrize("methods", ["none", "zv,none"])
def test_a_bad_file_is_refused_in_one_line(part, capsys, bad, told, methods):
    part.write_bytes(bad)
    assert run(part, "-m", methods, "--csv", part.with_name("path.csv"), "--json", part.with_name("f.json")) == 1
    said = one_line(capsys)
    assert all(words in said for words in [str(part), *told]), said
    assert names(part) == [part.name]


def test_what_cannot_be_read_is_told(part, capsys):
    assert run(part.parent) == 1
    assert "directory" in one_line(capsys)
    assert run(part.with_name("none.gcode")) == 1
    assert "none.gcode: No such file" in one_line(capsys)
    assert run(part, "--plant", "tax6") == 1
    assert "did you mean taz6?" in one_line(capsys)
    assert run(part, "--accel", 1e6) == 1
    assert "more than the machine stands" in one_line(capsys)


def test_targets_must_not_clash(part, capsys):
    out = part.with_name("out")
    assert run(part, "--csv", part) == 2
    assert "is FILE itself" in capsys.readouterr().err
    assert run(part, "--csv", out, "--json", out) == 2
    assert "two things would be written" in capsys.readouterr().err
    assert run(part, "--csv", part.parent / "no" / "path.csv") == 1
    assert "there is no folder" in one_line(capsys)
    assert names(part) == [part.name]


def test_a_file_without_motion_has_no_errors(part, capsys):
    part.write_text("; nothing but a comment\nM104 S200\n")
    assert run(part) == 0
    told = figures(part)
    assert all(one["conditions"]["as modelled"]["total"]["contour"]["max"] == 0.0 for one in told["results"])


def test_a_full_disk_leaves_nothing_behind(part):
    def small() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    command = [*SIMULATE, "-q", str(part), "--csv", str(part.with_name("path.csv"))]
    done = subprocess.run(command, preexec_fn=small, capture_output=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.count(b"\n") == 1 and b"File too large" in done.stderr
    assert names(part) == [part.name]


def test_ctrl_c_leaves_nothing_behind(part):
    part.write_text(PART + "G1 X30 Y30\nG1 X40 Y30\n" * 200_000)
    doing = subprocess.Popen([*SIMULATE, "-q", str(part), "--csv", str(part.with_name("path.csv"))],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)  # fmt: skip
    while doing.poll() is None and len(names(part)) < 2:
        time.sleep(0.05)
    doing.send_signal(signal.SIGINT)
    _, told = doing.communicate(timeout=60)
    assert (doing.returncode, told) == (130, b"fbf: interrupted\n")
    assert names(part) == [part.name]


def test_a_reader_that_goes_away_ends_it_quietly(part):
    part.write_text(PART + "G1 X30 Y30\nG1 X40 Y30\n" * 500)
    doing = subprocess.Popen([*SIMULATE, "-q", str(part), "--csv", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert doing.stdout and doing.stderr
    os.read(doing.stdout.fileno(), 10)
    doing.stdout.close()
    assert doing.stderr.read() == b""
    assert doing.wait(60) == 141


def test_the_default_methods_are_those_of_the_help(capsys):
    assert main.run(["simulate", "--help"]) == 0
    assert "none,auto" in capsys.readouterr().out.replace(" ", "")
    assert Wanted.methods == ("none", "auto") and set(Wanted.methods) <= set(METHODS)


def test_numpy_is_not_needed_to_ask_for_help():
    code = "import sys; from fbfcli.cli import main; main.run(['simulate', '--help']); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_compensate_makes_a_shaper_for_the_frequencies_that_are_told(part):
    one = figures(part, "-m", "ei")["results"][0]
    told = part.with_name("told.json")
    shaped = ",".join(f"{made['frequency']:.12g}" for made in one["made_for"])
    words = ["compensate", *PRINTER, str(part), "-n", "-q", "-m", "ei", "--shaped", shaped, "--json", str(told)]
    assert main.run(words) == 0
    assert json.loads(told.read_text())["contour_after"] == pytest.approx(one["compensated"]["contour_after"])
    assert main.run([*words[:5], "-m", "lpfbs", "--shaped", "30"]) == 2
