"""Every format can be read again, and says so where it cannot."""

from __future__ import annotations

import io
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from step_cases import DT, MOTORS, cut_out, streams, whole, written

from fbfcli.cli.npz_archive import NpzWriter, read_npz
from fbfcli.cli.steps import ENDINGS
from fbfcli.errors import FbfError
from fbfcli.printer import Driver
from fbfcli.steps.compact import CompactWriter, read_compact
from fbfcli.steps.csv_steps import CsvWriter, read_csv
from fbfcli.steps.formats import WRITERS, Wanted
from fbfcli.steps.pages import PagesWriter, read_pages
from fbfcli.steps.positions import read_positions
from fbfcli.steps.stream import Motors, MotorSteps
from fbfcli.steps.vcd import VcdWriter, read_vcd

TOLERANCE = 1000  # ns


def same(read: dict[str, MotorSteps], pieces, tolerance: int) -> None:
    """The steps that were read are those of the pieces, times within a tolerance [ns]."""
    for name, steps in whole(pieces).items():
        if name not in read:
            assert not len(steps)
            continue
        assert (read[name].forward == steps.forward).all()
        assert (np.abs(read[name].time - steps.time) <= tolerance).all()


@given(streams())
def test_csv_is_exact(pieces):
    same(read_csv(written(CsvWriter(MOTORS), pieces)), pieces, 0)


@given(streams())
def test_csv_is_in_the_order_of_time(pieces):
    rows = written(CsvWriter(MOTORS), pieces).decode().splitlines()[1:]
    time = [float(row.split(",")[0]) for row in rows]
    assert time == sorted(time)


@given(streams())
def test_npz_is_exact(pieces):
    with ExitStack() as files:
        data = written(NpzWriter(MOTORS, files), pieces)
    same(read_npz(data), pieces, 0)
    arrays = np.load(io.BytesIO(data))
    assert tuple(arrays["motors"]) == MOTORS.names
    assert tuple(arrays["steps_per_mm"]) == MOTORS.steps_per_mm


@given(streams(), st.sampled_from([1, 30, TOLERANCE, 20_000]))
def test_compact_keeps_its_tolerance(pieces, tolerance):
    same(read_compact(written(CompactWriter(MOTORS, tolerance), pieces)), pieces, tolerance)


@pytest.mark.parametrize(("rate", "tick"), [(250e3, 1000), (200e3, 1000), (255e3, 100)])
@given(pieces=streams())
def test_vcd_keeps_its_tick(rate, tick, pieces):
    data = written(VcdWriter(MOTORS, Driver(max_step_rate=rate)), pieces)
    same(read_vcd(data), pieces, tick // 2)


@given(pieces=streams())
def test_vcd_pulses_and_directions_last_as_long_as_the_driver_wants(pieces):
    """From the text alone: ticks of 1 us, pulses of 2 and pauses of 1 at least, DIR a tick before the step."""
    now, last = 0, {}
    for line in written(VcdWriter(MOTORS, Driver()), pieces).decode().partition("$end\n#0\n")[2].splitlines():
        if line[0] == "#":
            assert int(line[1:]) > now or now == 0
            now = int(line[1:])
        elif line[0] in "01" and now:
            motor, is_dir = divmod(ord(line[1]) - ord("!"), 2)
            if is_dir:
                last[motor, "dir"] = now
            elif line[0] == "1":
                assert now - last.get((motor, "low"), -9) >= 1
                assert now - last.get((motor, "dir"), -9) >= 1
                last[motor, "high"] = now
            else:
                assert now - last[motor, "high"] == 2
                last[motor, "low"] = now


def test_the_example_in_the_documentation():
    page = (Path(__file__).parents[2] / "docs" / "steps.md").read_text()
    rows = page.partition('motor "x" with 80 steps/mm')[2].split("```")[1].strip().splitlines()
    data = bytes.fromhex("".join(row.split("    ")[0] for row in rows))
    assert read_compact(data)["x"].time.tolist() == [1_000_000, 1_001_000, 1_002_000]
    steps = MotorSteps(np.array([1_000_000, 1_001_000, 1_002_000]), np.ones(3, dtype=bool))
    assert written(CompactWriter(Motors(("x",), (80.0,))), (cut_out([steps], 0, 2_000_000),)) == data


RATE = 1_750_000  # ticks per second: segments of 4 us, the closest steps there are
SEGMENT = 4_000


@given(seed=st.integers(0, 9999), count=st.integers(0, 400))
def test_pages_hold_the_steps_of_each_segment(seed, count):
    rng = np.random.default_rng(seed)
    motors = [
        MotorSteps(np.cumsum(rng.integers(4_000, 300_000, count)), np.repeat(rng.random(count) < 0.5, 9)[:count])
        for _ in MOTORS.names
    ]
    end = max([int(one.time[-1]) for one in motors if len(one)], default=0) + 1
    pieces = tuple(cut_out(motors, a, b) for a, b in ((0, end // 3), (end // 3, end // 2), (end // 2, end)))
    read = read_pages(written(PagesWriter(MOTORS, RATE), pieces))
    for steps, name in zip(motors, "xyz", strict=True):
        segments = 1 + max(steps.time[-1:].tolist() + read[name].time[-1:].tolist() + [0]) // SEGMENT
        sums = [
            np.bincount(one.time // SEGMENT, np.where(one.forward, 1, -1), segments) for one in (steps, read[name])
        ]
        assert (sums[0] == sums[1]).all()


READERS = {"csv": read_csv, "npz": read_npz, "compact": read_compact, "vcd": read_vcd, "marlin": read_pages}


@pytest.mark.parametrize("name", READERS)
@given(noise=st.binary(max_size=60))
def test_what_is_not_a_stream_is_refused(name, noise):
    with pytest.raises(FbfError):
        READERS[name](b"\xff" + noise)


@given(pieces=streams(), data=st.data())
def test_a_compact_file_that_is_cut_off_is_refused(pieces, data):
    whole_file = written(CompactWriter(MOTORS), pieces)
    cut = data.draw(st.integers(0, len(whole_file) - 1))
    with pytest.raises(FbfError):
        read_compact(whole_file[:cut])


def test_a_page_with_a_wrong_checksum_is_refused():
    data = bytearray(b"G6 R7000\n!\x00" + bytes([0x77]) * 256 + b"\x00G6 I0\n")
    assert not len(read_pages(bytes(data))["x"])
    data[60] ^= 1
    with pytest.raises(FbfError, match="checksum"):
        read_pages(bytes(data))


@pytest.mark.parametrize(("text", "told"), [(b"1 2\n1 x\n", "line 2"), (b"1 2\n1\n", "line 2")])
def test_positions_that_halstreamer_would_skip_are_refused(text, told):
    with pytest.raises(FbfError, match=told):
        read_positions(text)


def test_every_format_of_the_verb_has_a_writer():
    assert {*WRITERS, "npz"} == set(ENDINGS)
    wanted = Wanted(MOTORS, Driver(), DT, None)
    for make in WRITERS.values():
        assert isinstance(b"".join(make(wanted).head()), bytes)
