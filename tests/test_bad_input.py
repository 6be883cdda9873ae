"""When something is wrong `fbf compensate` says one clear line, and nothing is lost."""

from __future__ import annotations

import os
import re
import shutil
import signal
import stat
import subprocess
import time

import pytest
from part_cases import COMPENSATE, PART, ROOT, names, one_line, run

from fbfcli.cli import main

pytestmark = pytest.mark.usefixtures("nobody")


@pytest.mark.parametrize(("bad", "told"), [
    (b"", ["empty"]),
    (b"\x7fELF\0\0\1", ["binary"]),
    (b"GCDE\1\0\0\0", ["binary G-code", "PrusaSlicer"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 Xnan Y5\n", [":3:", "G1 Xnan Y5"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 Xinf\n", [":3:", "G1 Xinf"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 X1e300\n", [":3:", "G1 X1e300"]),
    (b"G28\nG1 X10 Y10 F3000\nG92 X1e300\n", [":3:", "G92 X1e300"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 X" + b"9" * 40 + b"\n", [":3:", "X is absurdly large"]),
    (b"G28\nG1 X10 Y10 F3000\nM204 Snan\n", [":3:", "M204 Snan"]),
    (b"G28\nG1 X10 Y10 F3000\nG2 X50 Y50\n", [":3:", "I, J or R"]),
    (b"G28\nG1 X10 Y10 F0\nG1 X20\n", [":2:", "F must be above zero"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 X900\n", [":3:", "X900", "-20 to 300 mm"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 Y-30\n", [":3:", "Y-30", "travel"]),
    (b"G28\nG1 X10 Y10 F3000\nG1 Z9999\n", [":3:", "Z9999", "travel"]),
], ids=str)  # fmt: skip
@pytest.mark.parametrize("in_place", [False, True])
def test_a_bad_file_is_refused_in_one_line(part, capsys, bad, told, in_place):
    part.write_bytes(bad)
    assert run(*["-i"] * in_place, part) == 1
    said = one_line(capsys)
    assert all(words in said for words in [str(part), *told]), said
    assert names(part) == [part.name]
    assert part.read_bytes() == bad


def test_the_place_is_told_far_down_a_file(part, capsys):
    part.write_text(PART + "G1 X30 Y30\nG1 X40 Y30\n" * 60_000 + "G1 X30 Xoops\n")  # several chunks
    assert run(part, "-q") == 1
    assert f"my part.gcode:{PART.count(chr(10)) + 120_001}: " in one_line(capsys)
    assert names(part) == [part.name]


def test_a_directory_is_not_a_file(part, capsys):
    assert run(part.parent) == 1
    assert "directory" in one_line(capsys)


def test_a_file_that_is_not_there(part, capsys):
    assert run(part.with_name("none.gcode")) == 1
    assert "none.gcode: No such file" in one_line(capsys)


def test_a_folder_that_is_not_there_is_told_by_the_name_given(part, capsys):
    assert run(part, "-q", "-o", part.parent / "no" / "out.gcode") == 1
    said = one_line(capsys)
    assert "out.gcode" in said
    assert ".tmp" not in said


UNSTABLE = "b = [0.0, -0.01]\na = [1.0, -1.01]\ndt = 0.001"
MODEL = "modes = [{ frequency = 28.0, damping = 0.05 }]"


@pytest.mark.parametrize(("old", "new", "told"), [
    (MODEL, UNSTABLE, ["axis", "unstable"]),
    ("command_velocity", "comand_velocity", ["comand_velocity", "command_velocity"]),
    ("frequency = 28.0", "frequency = nan", ["frequency"]),
    ('firmware = "klipper"', 'firmware = "kliper"', ["kliper", "klipper"]),
], ids=["unstable model", "misspelt key", "nan", "misspelt firmware"])  # fmt: skip
def test_a_bad_profile_is_refused_in_one_line(part, capsys, tmp_path, old, new, told):
    text = (ROOT / "configs" / "synthetic_bed_slinger.toml").read_text()
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new))
    assert main.run(["compensate", "-i", str(part), "-p", str(tmp_path / "mine.toml")]) == 1
    said = one_line(capsys)
    assert all(words in said for words in ["mine.toml", *told]), said
    assert part.read_text() == PART


def without_privilege(*words: str) -> subprocess.CompletedProcess:
    """Run it bound by permission bits, which root is not unless it gives that up."""
    bound: list[str] = []
    if os.geteuid() == 0:
        bound = ["setpriv", "--inh-caps=-all", "--bounding-set=-dac_override,-dac_read_search"]
        if not shutil.which("setpriv") or subprocess.run([*bound, "true"], capture_output=True).returncode:
            pytest.skip("root cannot give up its privileges here")
    return subprocess.run([*bound, *COMPENSATE, "-q", *words], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("in_place", [False, True])
def test_no_permission_to_write(part, in_place):
    part.parent.chmod(0o555)
    done = without_privilege(*["-i"] * in_place, str(part))
    assert done.returncode == 1
    assert re.fullmatch(r"fbf: error: .*part.*: Permission denied\n", done.stderr)
    assert ".tmp" not in done.stderr
    assert names(part) == [part.name]
    assert part.read_text() == PART


def test_no_permission_to_read(part):
    part.chmod(0)
    done = without_privilege(str(part))
    assert (done.returncode, done.stderr) == (1, f"fbf: error: {part}: Permission denied\n")
    assert names(part) == [part.name]


@pytest.mark.parametrize("in_place", [False, True])
def test_a_full_disk_loses_nothing(tmp_path, in_place):
    """A disk of 64 kB, mounted where only this test sees it."""
    disk = tmp_path / "disk"
    disk.mkdir()
    own = ["unshare", "--mount", "sh", "-c"]
    mount = f"mount -t tmpfs -o size=64k tmpfs '{disk}' && cd '{disk}'"
    if not shutil.which("unshare") or subprocess.run([*own, mount], capture_output=True).returncode:
        pytest.skip("no disk can be mounted here")
    (tmp_path / "long.gcode").write_text(PART + "G1 X30 Y30\nG1 X40 Y35\n" * 1000)
    command = " ".join([*COMPENSATE, "-q", *["-i"] * in_place, "part.gcode"])
    then = "echo $?; ls -A; cmp part.gcode ../long.gcode && echo intact"
    script = f"{mount} && cp ../long.gcode part.gcode && {command}; {then}"
    done = subprocess.run([*own, script], capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["1", "part.gcode", "intact"]
    assert done.stderr.count("\n") == 1
    assert re.match(r"fbf: error: .*No space left on device", done.stderr)


def test_a_full_standard_output_is_an_error(part):
    with open("/dev/full", "wb") as full:
        if not stat.S_ISCHR(os.fstat(full.fileno()).st_mode):
            pytest.skip("/dev/full is no device here")
        done = subprocess.run([*COMPENSATE, "-q", str(part), "-o", "-"], stdout=full, stderr=subprocess.PIPE, text=True,
                              timeout=60)
    assert done.returncode == 1
    assert done.stderr == "fbf: error: No space left on device\n"


def test_a_full_device_is_told_by_its_name(part):
    if not (os.path.exists("/dev/full") and stat.S_ISCHR(os.stat("/dev/full").st_mode)):
        pytest.skip("/dev/full is no device here")
    done = subprocess.run([*COMPENSATE, "-q", str(part), "-o", "/dev/full"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (1, "fbf: error: /dev/full: No space left on device\n")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("in_place", [False, True])
def test_an_interrupted_run_loses_nothing(part, number, code, in_place):
    whole = PART + "G1 X30 Y30 E.5 F3000\nG1 X90 Y40 E.5\n" * 200_000
    part.write_text(whole)
    doing = subprocess.Popen([*COMPENSATE, "-q", *["-i"] * in_place, str(part)], stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 60
        while not any(file.stat().st_size for file in part.parent.glob(".*.tmp")):  # it is writing
            assert doing.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.02)
        doing.send_signal(number)
        _, said = doing.communicate(timeout=60)
    finally:
        doing.kill()
        doing.wait()
    assert doing.returncode == code
    assert said in ("fbf: interrupted\n", "fbf: terminated\n")
    assert names(part) == [part.name]
    assert part.read_text() == whole


def test_a_reader_that_goes_away_is_no_traceback(part):
    part.write_text(PART + "G1 X30 Y30 E.5 F3000\nG1 X90 Y40 E.5\n" * 2000)
    doing = subprocess.Popen([*COMPENSATE, "-q", str(part), "-o", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert doing.stdout and doing.stderr
    doing.stdout.close()
    said = doing.stderr.read()
    doing.stderr.close()
    assert doing.wait(timeout=60) == 141
    assert said == b""
