"""`fbf simulate` with the motors of a profile: their load is told, and where they lose steps, by line and time."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from fbfcli.cli.main import fbf

SQUARE = """\
G28
G90
M82
G92 E0
G1 Z0.2 F600
G1 X100 Y100 F12000
G1 X140 Y100 E2 F9000
G1 X140 Y140 E4
G1 X100 Y140 E6
G1 X100 Y100 E8
"""
FIRST_MOVE, LAST_LINE = 6, 10


def simulated(tmp_path: Path, root: Path, **changes: str) -> tuple[str, dict]:
    """Words and results of a square on the bundled bed slinger, lines of whose profile are changed."""
    profile = (root / "configs" / "synthetic_bed_slinger.toml").read_text()
    for key, value in changes.items():
        lines = profile.splitlines()
        profile = "\n".join(f"{key} = {value}" if line.split(" = ")[0] == key else line for line in lines)
    (tmp_path / "mine.toml").write_text(profile)
    (tmp_path / "part.gcode").write_text(SQUARE)
    asked = ["simulate", str(tmp_path / "part.gcode"), "-p", str(tmp_path / "mine.toml"), "-m", "none,lpfbs"]
    run = CliRunner().invoke(fbf, [*asked, "--json", str(tmp_path / "told.json")])
    assert run.exit_code == 0, run.output
    return run.stderr, json.loads((tmp_path / "told.json").read_text())


def test_motors_that_suffice_lose_nothing_and_work_harder_uncompensated(tmp_path, root):
    words, told = simulated(tmp_path, root)
    none, lpfbs = (result["motors"] for result in told["results"])
    assert not none["lost"] and not lpfbs["lost"] and "loses" not in words
    assert [motor["name"] for motor in none["motors"]] == ["x", "y"]
    assert all(0.05 < motor["share"] < 1.0 for motor in none["motors"])
    assert none["motors"][1]["share"] > lpfbs["motors"][1]["share"]
    assert FIRST_MOVE <= none["motors"][0]["share_at"]["line"] <= LAST_LINE


def test_motors_that_do_not_suffice_lose_steps_by_line_and_time_and_the_verb_goes_well(tmp_path, root):
    words, told = simulated(tmp_path, root, run_current="0.15")
    for result in told["results"]:
        lost = result["motors"]["lost"]
        assert lost and all(one["steps"] % 4 == 0 for one in lost)
        assert all(FIRST_MOVE <= one["line"] <= LAST_LINE and 0 < one["time"] <= result["time"] for one in lost)
    assert "warning: none: motor" in words and "warning: lpfbs: motor" in words
    assert "rotors are integrated where" in words


def test_a_profile_without_motors_says_that_it_has_none(tmp_path, root):
    (tmp_path / "part.gcode").write_text(SQUARE)
    asked = ["simulate", str(tmp_path / "part.gcode"), "-p", "taz6", "-m", "none", "--json", "-"]
    run = CliRunner().invoke(fbf, asked)
    assert run.exit_code == 0
    assert "describes no motor" in run.stderr
    assert json.loads(run.stdout)["results"][0]["motors"]["motors"] == []


@pytest.mark.parametrize("rate", ["1000", "5000"])
def test_the_load_does_not_depend_on_the_rate(tmp_path, rate):
    (tmp_path / "part.gcode").write_text(SQUARE)
    asked = ["simulate", str(tmp_path / "part.gcode"), "-p", "synthetic_corexy", "-m", "none", "--json", "-", "-q"]
    shares = [
        [motor["share"] for motor in json.loads(run.stdout)["results"][0]["motors"]["motors"]]
        for run in (CliRunner().invoke(fbf, [*asked, "--rate", each]) for each in ("2000", rate))
    ]
    assert shares[0] == pytest.approx(shares[1], rel=0.1)
