"""The command itself: what it prints where, how it leaves, and how it finds a printer."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fbfcli import __version__
from fbfcli.cli import lookup, main
from fbfcli.errors import ProfileError

ROOT = Path(__file__).parents[1]
BED_SLINGER = ROOT / "configs" / "synthetic_bed_slinger.toml"


@pytest.fixture(autouse=True)
def nobody(monkeypatch, tmp_path):
    """A user without a printer."""
    monkeypatch.delenv("FBF_PRINTER", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))


def own(text: str) -> Path:
    """Give the user a printer."""
    lookup.own_file().parent.mkdir(parents=True, exist_ok=True)
    lookup.own_file().write_text(text)
    return lookup.own_file()


def fbf(*words: str, **options) -> subprocess.CompletedProcess:
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "timeout": 60} | options
    return subprocess.run([sys.executable, "-m", "fbfcli.cli.main", *words], stdin=subprocess.DEVNULL, **options)


def test_printers_lists_every_bundled_profile(capsys):
    assert main.run(["printers"]) == 0
    said = capsys.readouterr()
    assert not said.err
    heading, *lines = said.out.splitlines()
    assert heading.split() == ["name", "firmware", "kinematics", "modes", "source"]
    assert {line.split()[0] for line in lines} == {file.stem for file in (ROOT / "configs").glob("*.toml")}
    assert next(line for line in lines if line.startswith("taz6")).count("24.8 + 33.4 Hz") == 2


def test_printers_as_json(capsys):
    own(BED_SLINGER.read_text())
    assert main.run(["printers", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    x = rows["synthetic_bed_slinger"]["modes"]["x"]
    assert x == [[pytest.approx(35.0), pytest.approx(0.05)]]
    assert str(lookup.own_file()) in rows


def test_a_broken_profile_of_ones_own_does_not_hide_the_others(capsys):
    own("[printer]\nname = 3\n")
    assert main.run(["printers"]) == 1
    said = capsys.readouterr()
    assert "taz6" in said.out
    assert said.err.count("\n") == 1
    assert "printer.toml: " in said.err


def test_check_accepts_what_is_good(capsys):
    assert main.run(["printers", "check", str(BED_SLINGER), "taz6"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{BED_SLINGER}: good: klipper, cartesian; x 35.0 Hz, y 28.0 Hz"
    assert len(said) == 2


def test_check_refuses_an_unstable_model(capsys, tmp_path):
    text = BED_SLINGER.read_text().replace("modes = [{ frequency = 28.0, damping = 0.05 }]",
                                           "b = [0.0, -0.01]\na = [1.0, -1.01]\ndt = 0.001")
    (tmp_path / "mine.toml").write_text(text)
    assert main.run(["printers", "check", "taz6", str(tmp_path / "mine.toml")]) == 1
    said = capsys.readouterr()
    assert said.out.startswith("taz6: good")
    assert said.err.startswith(f"fbf: error: {tmp_path / 'mine.toml'}: axis.y.model: ")
    assert said.err.count("\n") == 1


@pytest.mark.parametrize(("said_of_y", "key"), [
    ("[axis.y.uncertainty]\nfamily = [{ b = [0.0, -0.01], a = [1.0, -1.01], dt = 0.001 }]", "uncertainty"),
    ("[[axis.y.at]]\nz = 0\nmodel = { b = [0.0, -0.01], a = [1.0, -1.01], dt = 0.001 }", "at[0].model"),
])  # fmt: skip
def test_check_looks_at_every_model_of_an_axis(capsys, tmp_path, said_of_y, key):
    (tmp_path / "mine.toml").write_text(BED_SLINGER.read_text() + "\n" + said_of_y + "\n")
    assert main.run(["printers", "check", str(tmp_path / "mine.toml")]) == 1
    assert f"mine.toml: axis.y.{key}: " in capsys.readouterr().err


def test_responses_are_looked_for_beside_the_profile(tmp_path, monkeypatch):
    text = BED_SLINGER.read_text().replace("modes = [{ frequency = 28.0, damping = 0.05 }]",
                                           'impulse_response = "h.csv"\ndt = 0.001')
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ProfileError, match=r"h\.csv: No such file"):
        lookup.find_printer(str(tmp_path / "mine.toml"))
    (tmp_path / "h.csv").write_text("0.5\n0.5\n")
    assert lookup.find_printer(str(tmp_path / "mine.toml")).axes[1].model.h == (0.5, 0.5)


def test_the_printer_is_the_one_named_then_the_environments_then_ones_own(monkeypatch, tmp_path):
    with pytest.raises(ProfileError, match=r"-p NAME or -p FILE .*FBF_PRINTER.*printer\.toml"):
        lookup.find_printer(None)
    own(BED_SLINGER.read_text().replace("Synthetic bed slinger", "mine"))
    assert lookup.find_printer(None).name == "mine"
    monkeypatch.setenv("FBF_PRINTER", "taz6")
    assert lookup.find_printer(None).name == "LulzBot TAZ 6"
    assert lookup.find_printer("hictop_prusa_i3").name == "HICTOP Prusa i3"
    assert lookup.find_printer(str(lookup.own_file())).name == "mine"


@pytest.mark.parametrize(("name", "words"), [
    ("synthetic_bedslinger", "did you mean synthetic_bed_slinger?"),
    ("nothing/like/it", "no such printer profile"),
    ("it.toml", "no such printer profile"),
    ("zzz", "Bundled are"),
])
def test_a_printer_that_is_not_there_is_one_line(capsys, name, words):
    assert main.run(["printers", "check", name]) == 1
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_a_profile_that_is_no_text_is_refused(tmp_path, capsys):
    (tmp_path / "x.toml").write_bytes(b"\xff\xfe\x00")
    assert main.run(["printers", "check", str(tmp_path / "x.toml")]) == 1
    assert "is not text in UTF-8" in capsys.readouterr().err
    assert main.run(["printers", "check", str(tmp_path)]) == 1
    assert "Is a directory" in capsys.readouterr().err


def test_help_needs_no_numpy():
    quick = "import sys; from fbfcli.cli.main import run; run(['--help']); assert 'numpy' not in sys.modules"
    done = subprocess.run([sys.executable, "-c", quick], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert all(verb in done.stdout for verb in main.VERBS)


def test_version():
    done = fbf("--version")
    assert (done.returncode, done.stdout) == (0, f"fbf {__version__}\n")


@pytest.mark.parametrize(("words", "hint"), [
    (["printesr"], "Did you mean 'printers'?"),
    (["printers", "--jsno"], "--json"),
    (["printers", "check"], "NAME|FILE"),
])
def test_a_wrong_command_line_leaves_with_2(capsys, words, hint):
    assert main.run(words) == 2
    assert hint in capsys.readouterr().err


def test_interrupted_is_one_line_and_130(monkeypatch, capsys):
    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr("fbfcli.cli.printers.bundled_files", interrupt)
    assert main.run(["printers"]) == 130
    assert capsys.readouterr().err == "fbf: interrupted\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
def test_a_full_disk_is_one_line():
    with open("/dev/full", "w") as full:
        done = fbf("printers", stdout=full)
    assert (done.returncode, done.stderr) == (1, "fbf: error: No space left on device\n")


def test_a_listener_that_left_is_no_error():
    read, write = os.pipe()
    os.close(read)
    done = fbf("printers", stdout=write)
    os.close(write)
    assert (done.returncode, done.stderr) == (141, "")
