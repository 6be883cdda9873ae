"""`fbf compensate` from outside: files and pipes, and what it says."""

from __future__ import annotations

import json
import os
import re
import stat
import subprocess
import sys

import pytest
from part_cases import COMPENSATE, CONFIG, HEAD, PART, names, one_line, run

from fbfcli.cli import main
from fbfcli.gcode.stamp import is_stamped

pytestmark = pytest.mark.usefixtures("nobody")


# files and pipes

def test_the_new_file_stands_beside_the_old_one(part):
    assert run(part) == 0
    assert names(part) == ["my part.fbf.gcode", "my part.gcode"]
    assert part.read_text() == PART
    assert is_stamped(part.with_name("my part.fbf.gcode").read_bytes())


def test_a_new_file_is_readable_as_any_other(part):
    run(part)
    ordinary = part.with_name("ordinary")
    ordinary.touch()
    assert part.with_name("my part.fbf.gcode").stat().st_mode == ordinary.stat().st_mode


def test_o_names_the_file(part):
    assert run(part, "-o", part.with_name("other.g")) == 0
    assert names(part) == ["my part.gcode", "other.g"]


def test_o_dash_and_stdin_are_the_same_text(part):
    to_stdout = subprocess.run([*COMPENSATE, str(part), "-o", "-"], capture_output=True, timeout=60)
    with part.open("rb") as stdin:
        piped = subprocess.run([*COMPENSATE, "-"], stdin=stdin, capture_output=True, timeout=60)
        stdin.seek(0)
        bare = subprocess.run(COMPENSATE, stdin=stdin, capture_output=True, timeout=60)
    assert to_stdout.returncode == piped.returncode == bare.returncode == 0
    assert to_stdout.stdout == piped.stdout == bare.stdout
    assert is_stamped(piped.stdout)
    assert b"print time" in piped.stderr
    assert names(part) == ["my part.gcode"]


def test_in_place_keeps_mode_and_link(part):
    part.chmod(0o640)
    link = part.with_name("link.gcode")
    link.symlink_to(part.name)
    assert run("-i", link) == 0
    assert names(part) == ["link.gcode", "my part.gcode"]
    assert link.is_symlink()
    assert is_stamped(part.read_bytes())
    assert stat.S_IMODE(part.stat().st_mode) == 0o640


def test_a_pipe_is_never_replaced(part):
    """Nor is a device: -o /dev/null must leave one."""
    fifo = part.with_name("pipe")
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    try:
        done = subprocess.run([*COMPENSATE, "-q", str(part), "-o", str(fifo)], capture_output=True, timeout=60)
        assert stat.S_ISFIFO(fifo.stat().st_mode)
        assert done.returncode == 1 or is_stamped(os.read(reader, 1 << 16))
    finally:
        os.close(reader)


@pytest.mark.parametrize("dry", [[], ["--dry-run"]])
def test_json_goes_to_a_file_or_to_stdout(part, capsys, dry):
    assert run(part, *dry, "--json", part.with_name("figures.json")) == 0
    told = json.loads(part.with_name("figures.json").read_text())
    assert run(part, *dry, "--json", "-") == 0
    assert json.loads(capsys.readouterr().out) == told
    assert told["printer"] == "LulzBot TAZ 6"
    assert told["time"] == pytest.approx(told["time_as_sliced"], rel=0.5)
    assert set(told["contour_after"]) == {"rms", "p99", "max"}


def test_dry_run_writes_nothing(part, capsys):
    assert run(part, "--dry-run") == 0
    assert run("-n", "-i", part) == 0
    assert names(part) == [part.name]
    assert part.read_text() == PART
    said = capsys.readouterr()
    assert not said.out
    assert "print time" in said.err


def test_quiet_is_silent(part, capsys):
    assert run(part, "-q") == 0
    assert capsys.readouterr() == ("", "")


def test_quiet_still_tells_errors(part, capsys):
    assert run(part.with_name("none.gcode"), "-q") == 1
    assert "none.gcode" in capsys.readouterr().err


def test_a_stamped_file_is_refused_unless_forced(part, capsys):
    assert run("-i", "-q", part) == 0
    once = part.read_bytes()
    assert run("-i", "-q", part) == 1
    assert part.read_bytes() == once
    assert "--force" in one_line(capsys)
    assert run("-i", "-q", "--force", part) == 0
    assert part.read_bytes() != once


def test_errors_and_figures_go_to_the_log(part):
    log = part.with_name("fbf.log")
    run(part, "--log", log)
    run("-i", part.with_name("my part.fbf.gcode"), "--log", log)
    run(part.with_name("none.gcode"), "--log", log)
    *figures, stamped, absent = log.read_text().splitlines()
    assert "print time" in figures[0]
    assert stamped.startswith("error: ")
    assert "none.gcode" in absent
    assert "No such file" in absent


# what slicers and hosts read back

def test_head_and_tail_stay_byte_for_byte(part):
    run("-i", part)
    text = part.read_text()
    first, _, rest = text.partition("\n")
    assert first + "\n" == HEAD.splitlines(keepends=True)[0]
    assert rest.startswith("; fbf ")
    assert text.replace(rest.partition("\n")[0] + "\n", "").startswith(HEAD)
    assert CONFIG in text


def test_progress_and_comments_tell_the_new_time(part):
    long = "".join(f"G1 X{20 + 60 * (i % 2)} E1 F600\n" for i in range(60))  # six minutes
    part.write_text(PART.replace("M73 P50", long + "M73 P50"))
    figures = part.with_name("figures.json")
    run("-i", part, "--json", figures)
    total = json.loads(figures.read_text())["time"]
    text = part.read_text()
    found = re.search(r"printing time[^=]*= (?:(\d+)h )?(?:(\d+)m )?(\d+)s", text)
    assert found
    h, m, s = (int(n or 0) for n in found.groups())
    assert 3600 * h + 60 * m + s == pytest.approx(total, abs=1)
    told = [(int(p), int(r)) for p, r in re.findall(r"^M73 P(\d+) R(\d+) *$", text, re.MULTILINE)]
    assert [p for p, _ in told] == sorted(p for p, _ in told)
    assert told[0] == (0, round(total / 60))
    assert told[-1] == (100, 0)
    assert told[1][0] == pytest.approx(100 * (1 - told[1][1] * 60 / total), abs=100 * 60 / total)


@pytest.mark.parametrize("ending", [b"\r\n", b"\n"])
def test_line_ends_stay_as_they_are(part, ending):
    part.write_bytes(PART.encode().replace(b"\n", ending))
    run("-i", part)
    heads = (b"G28", b"M83", b"; thumb", b"; layer")
    kept = [line for line in part.read_bytes().splitlines(keepends=True) if line.startswith(heads)]
    assert len(kept) == 5
    assert all(line.endswith(ending) and line.count(b"\r") == (ending == b"\r\n") for line in kept)


def test_an_unterminated_last_line_is_ended(part):
    part.write_text(PART + "M84")
    run("-i", part)
    assert "\nM84\n" in part.read_text()


# words

def test_help_is_instant():
    """It imports nothing that takes long; what it takes is told by benchmarks, not by a clock in a test."""
    code = "import sys; from fbfcli.cli.main import run; code = run(['--help']); print(*sys.modules); sys.exit(code)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    loaded = {name.split(".")[0] for name in told.stdout.splitlines()[-1].split()}
    assert "click" in loaded
    assert not loaded & {"numpy", "scipy", "matplotlib", "pygcode", "tomlkit", "pywt"}


def test_a_misspelt_option_is_suggested(part, capsys):
    assert run(part, "--tolerence", "5") == 2
    assert "--tolerance" in capsys.readouterr().err
    assert names(part) == [part.name]


def test_without_a_printer_it_says_how_to_get_one(part, capsys):
    assert main.run(["compensate", str(part)]) == 1
    said = one_line(capsys)
    assert all(words in said for words in ("-p NAME", "fbf printers", "FBF_PRINTER", "printer.toml"))


@pytest.mark.parametrize("words", [
    ["-i"], ["-i", "-o", "out"], ["-o", "-", "--json", "-"], ["--accel", "0"], ["-m", "magic"],
])  # fmt: skip
def test_a_wrong_command_line_is_exit_2(part, capsys, words):
    assert run(*words, *([part] if words != ["-i"] else [])) == 2
    assert names(part) == [part.name]


@pytest.mark.parametrize(("option", "value"), [
    ("--accel", "nan"), ("--accel", "inf"), ("--velocity", "nan"), ("--tolerance", "nan"), ("--tolerance", "inf"),
    ("--mu", "nan"), ("--mu", "inf"), ("--segments", "nan"),
])  # fmt: skip
def test_an_option_is_a_sensible_number(part, capsys, option, value):
    assert run(part, option, value) == 2
    assert option in capsys.readouterr().err
    assert names(part) == [part.name]


@pytest.mark.parametrize("option", ["--accel", "--velocity"])
def test_planning_with_more_than_the_machine_stands_is_refused(part, capsys, option):
    assert run(part, option, "1e5") == 1
    assert f"{option} 100000 is more than the machine stands: command_" in one_line(capsys)
    assert names(part) == [part.name]


def test_the_verb_names_every_method_and_auto():
    from fbfcli.cli.method_options import METHODS
    from fbfcli.control import design
    from fbfcli.pipeline.settings import AUTO

    assert sorted(METHODS) == sorted((AUTO, *design.METHODS))


@pytest.mark.parametrize(("words", "method", "why"), [
    ([], "contour", "does not say"), (["--spread", "2"], "lpfbs", "as asked for"), (["-m", "zv"], "zv", "")])
def test_the_summary_says_which_method_was_taken_and_why(part, capsys, words, method, why):
    run(part, "-n", "--json", "-", *words)
    told = json.loads(capsys.readouterr().out)
    assert told["method"] == method
    assert why in told["why"]


@pytest.mark.parametrize("words", [["-m", "zv", "--spread", "5"], ["--spread", "60"], ["--spread", "nan"],
                                   ["--extrusion", "maybe"], ["--fir", "500"]])  # fmt: skip
def test_options_that_do_not_fit_are_a_wrong_command_line(part, words):
    assert run(part, "-n", *words) == 2
