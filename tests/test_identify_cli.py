"""`fbf identify` as people use it: files in, a profile, a picture and words out; bad input in one line."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from response_cases import FS, ONE, swept

from fbfcli.cli.identify import identify
from fbfcli.cli.main import run
from fbfcli.cli.printers import printers
from fbfcli.pipeline.choice import chosen
from fbfcli.pipeline.settings import Settings
from fbfcli.printer import Family, Spread
from fbfcli.printer_toml import parse_printer


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A pair of command and measurement in a file whose name says nothing, with a blank in it."""
    x, y = swept(ONE, 0.05, np.random.default_rng(0), f1=70.0)
    file = tmp_path_factory.mktemp("recordings") / "a file.csv"
    rows = np.column_stack((np.arange(len(x)) / FS, x, y))
    np.savetxt(file, rows, "%.6f,%.2f,%.2f", header="time_s,accel_cmd_x,accel_meas_x", comments="")
    return file


@pytest.fixture(scope="module")
def identified(recording, tmp_path_factory):
    """What one run of the verb left behind."""
    folder = tmp_path_factory.mktemp("out")
    arguments = [str(recording), "-o", str(folder / "my.toml"), "--plot", str(folder / "bode.png"),
                 "--json", str(folder / "found.json"), "--band", "5", "70"]  # fmt: skip
    result = CliRunner().invoke(identify, arguments, catch_exceptions=False)
    return folder, result


def test_a_recording_becomes_a_profile_that_can_be_used(identified, monkeypatch):
    folder, result = identified
    found = json.loads((folder / "found.json").read_text())
    mode = found["modes"][0]
    assert mode["frequency"]["value"] == pytest.approx(38.0, rel=0.005)
    assert mode["damping"]["value"] == pytest.approx(0.05, rel=0.1)
    assert found["assumed"] == "" and found["acceleration_compensated"] > found["acceleration_uncompensated"]
    checked = CliRunner().invoke(printers, ["check", str(folder / "my.toml")], catch_exceptions=False)
    assert "good" in checked.stdout and "x 38" in checked.stdout
    assert "38." in result.stderr and not result.stdout


def test_the_picture_is_one(identified):
    assert (identified[0] / "bode.png").read_bytes().startswith(b"\x89PNG")


def test_the_other_axis_and_people_s_words_stay(recording, tmp_path, root):
    profile = tmp_path / "printer.toml"
    old = (root / "configs" / "synthetic_two_mode.toml").read_text()
    profile.write_text(old)
    assert run(["identify", str(recording), "-q", "-o", str(profile), "--band", "5", "70"]) == 0
    new = profile.read_text().splitlines()
    assert [line for line in old.splitlines() if line not in new] == ["modes = [{ frequency = 45.0, damping = 0.05, "
            "gain = 0.7 }, { frequency = 85.0, damping = 0.05, gain = 0.3 }]"]  # fmt: skip


def test_from_a_pipe_to_a_pipe(recording):
    result = CliRunner().invoke(identify, ["-", "-q", "-o", "-", "--band", "5", "70"], input=recording.read_bytes(),
                                catch_exceptions=False)  # fmt: skip
    assert "[axis.x.model]" in result.stdout and not result.stderr


def test_a_spectrum_is_labelled(tmp_path, capsys):
    file = tmp_path / "resonances_x.csv"
    f = np.arange(1.6, 200.0, 1.6)
    from fbfcli.plant.rational import response

    psd = 1e4 * np.abs(response(ONE, f)) ** 2 * f**2
    np.savetxt(file, np.column_stack((f, psd, 0.01 * psd, 0.01 * psd, 1.02 * psd)), "%.1f,%.3e,%.3e,%.3e,%.3e",
               header="freq,psd_x,psd_y,psd_z,psd_xyz", comments="")  # fmt: skip
    picture = tmp_path / "psd.svg"
    assert run(["identify", str(file), "--axis", "x", "--plot", str(picture)]) == 0
    words = capsys.readouterr().err
    assert "assumed:" in words and "minimum phase" in words
    assert b"<svg" in picture.read_bytes()


@pytest.mark.parametrize(
    "content, why",
    [
        (b"", "nothing in it|no numbers|empty"),
        (b"#time,accel_x,accel_y,accel_z\n", "no numbers"),
        (b"\x00\x01\x02binary" * 50, "x.csv"),
        (b"a,b\n1,2\n3,4\n", "x.csv"),
        (b"Sample,X,Y,Z\nFailed to start accelerometer\n", "failed"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(tmp_path, capsys, content, why):
    file, profile = tmp_path / "x.csv", tmp_path / "p.toml"
    file.write_bytes(content)
    assert run(["identify", str(file), "--axis", "x", "-o", str(profile)]) == 1
    words = capsys.readouterr().err
    assert words.count("\n") == 1 and words.startswith("fbf: error:")
    assert any(word in words for word in why.split("|"))
    assert not profile.exists()


@pytest.mark.parametrize(
    "arguments, code",
    [
        (["--plot", "bode.jpeg.txt"], 2),
        (["--band", "50", "60"], 2),
        (["-o", "-", "--json", "-"], 2),
        (["-o", "no/such/folder/p.toml"], 1),
        (["--sweep", "klippr"], 1),
        (["--sweep", "nothere.csv"], 1),
        (["--axis", "z"], 2),
        (["--at", "x=1"], 2),
        (["-o", "p.toml", "--at", "x=1,x=2"], 2),
        (["-o", "p.toml", "--at", "w=1"], 2),
        (["-o", "p.toml", "--at", "x=nan"], 2),
        (["-o", "p.toml", "--at", "mass=-1"], 2),
    ],
)
def test_wrong_options_are_refused_before_any_work(recording, arguments, code):
    assert run(["identify", str(recording), "-q", *arguments]) == code


def test_a_broken_profile_stays_as_it_was(recording, tmp_path, capsys):
    profile = tmp_path / "p.toml"
    profile.write_text("[printer]\nname = 3\n")
    assert run(["identify", str(recording), "-q", "-o", str(profile), "--band", "5", "70"]) == 1
    assert profile.read_text() == "[printer]\nname = 3\n"
    assert str(profile) in capsys.readouterr().err


def test_recordings_at_places_are_models_at_places(recording, tmp_path, capsys):
    profile = tmp_path / "p.toml"
    there = ["identify", str(recording), "-q", "-o", str(profile), "--band", "5", "70", "--at"]
    assert run([*there, "y=20, x=100"]) == 0
    (place,) = parse_printer(profile.read_text(), "p.toml").axes[0].at
    assert (place.x, place.y, place.z) == (100.0, 20.0, None)
    assert place.model.modes[0].frequency == pytest.approx(38.0, rel=0.005)
    assert run([*there, "z=3"]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_two_runs_make_a_family(recording, tmp_path):
    profile = tmp_path / "p.toml"
    assert run(["identify", str(recording), str(recording), "-q", "-o", str(profile), "--band", "5", "70"]) == 0
    assert "family" in profile.read_text()


def test_the_uncertainty_that_is_written_chooses_the_method(recording, tmp_path, root):
    """One recording of each axis: ranges of 0.5 %, near enough for lpfbs; wider ones are planned for by contour."""
    profile = tmp_path / "printer.toml"
    profile.write_text((root / "configs" / "synthetic_two_mode.toml").read_text())
    for axis in "xy":
        of_axis = tmp_path / f"{axis}.csv"
        of_axis.write_text(recording.read_text().replace("_x", f"_{axis}"))
        assert run(["identify", str(of_axis), "-q", "-o", str(profile), "--band", "5", "70"]) == 0
    written = profile.read_text()
    printer = parse_printer(written, "printer.toml")
    assert all(isinstance(axis.uncertainty, Spread) for axis in printer.axes[:2])
    assert chosen(printer, Settings()).method == "lpfbs"
    wider = re.sub(r"(?m)^frequency = .*$", "frequency = [0.9, 1.1]", written)
    assert chosen(parse_printer(wider, "printer.toml"), Settings()).method == "contour"


def test_a_family_that_is_written_is_planned_for(recording, tmp_path):
    profile = tmp_path / "p.toml"
    assert run(["identify", str(recording), str(recording), "-q", "-o", str(profile), "--band", "5", "70"]) == 0
    printer = parse_printer(profile.read_text(), "p.toml")
    assert isinstance(printer.axes[0].uncertainty, Family) and len(printer.axes[0].uncertainty.models) == 2
    assert "one of 2" in chosen(printer, Settings()).why
