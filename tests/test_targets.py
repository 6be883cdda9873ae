"""No verb writes over what it reads, or two things to one file; it says so before any work."""

from __future__ import annotations

import os
import shlex
import subprocess

import pytest
from part_cases import FBF, PART

from fbfcli.cli.main import run

PRINTER = ["-p", "synthetic_bed_slinger", "-q"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").write_text(PART)
    (tmp_path / "link").symlink_to("in")
    return tmp_path


@pytest.mark.parametrize("words", [
    ["compensate", "in", *PRINTER, "--json", "in"],
    ["compensate", "in", *PRINTER, "--json", "link"],
    ["compensate", "in", *PRINTER, "--log", "in"],
    ["compensate", "in", *PRINTER, "-n", "--json", "./in"],
    ["compensate", "in", *PRINTER, "--json", "in.fbf"],
    ["compensate", "in", *PRINTER, "-i", "--json", "in"],
    ["compensate", "in", *PRINTER, "-o", "out", "--log", "out"],
    ["steps", "in", *PRINTER, "-o", "out", "--events", "in"],
    ["steps", "in", *PRINTER, "-o", "out", "--events", "out"],
    ["steps", "in", *PRINTER, "-o", "out", "--json", "out.events.jsonl"],
    ["steps", "in", *PRINTER, "-n", "--json", "in"],
    ["excite", *PRINTER, "--axis", "x", "--csv", "out", "--json", "out"],
    ["excite", *PRINTER, "--axis", "x", "-o", "out.csv"],
    ["excite", "-p", "./in", "-q", "--axis", "x", "-o", "in"],
    ["identify", "in", "-q", "--json", "in"],
    ["identify", "in", "-q", "-o", "out", "--json", "out"],
    ["reproduce", "duan-2015-table-2", "--json", "out", "--markdown", "out"],
    ["reproduce", "duan-2015-table-2", "--part", "in", "--json", "in"],
], ids=" ".join)  # fmt: skip
def test_nothing_is_written_over(folder, capsys, words):
    assert run(words) == 2
    told = capsys.readouterr()
    assert not told.out and "another name" in told.err
    assert (folder / "in").read_text() == PART
    assert sorted(os.listdir()) == ["in", "link"]


@pytest.mark.parametrize("verb", ["compensate", "steps"])
def test_no_folder_is_said_of_a_dry_run_too(capsys, verb):
    assert run([verb, "in", *PRINTER, "-n", "--json", "no/such"]) == 1
    assert "there is no folder no" in capsys.readouterr().err


def test_a_device_takes_several_things():
    assert run(["compensate", "in", *PRINTER, "-o", os.devnull, "--json", os.devnull]) == 0


def test_a_file_may_be_changed_itself(folder):
    assert run(["compensate", "in", *PRINTER, "-o", "in"]) == 0
    assert (folder / "in").read_text() != PART


@pytest.mark.parametrize("words", [
    ["steps", "in", *PRINTER, "-o", "large"],
    ["excite", *PRINTER, "--axis", "x", "-o", "large", "--csv", "small"],
], ids=" ".join)  # fmt: skip
def test_of_two_files_the_one_that_failed_is_told(words):
    script = f"ulimit -f 1; exec {shlex.join([*FBF, *words])}"
    done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr == "fbf: error: large: cannot be written: File too large; it stays as it was\n"
    assert sorted(os.listdir()) == ["in", "link"]
