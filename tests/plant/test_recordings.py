"""Recordings: every kind by its content, every oddity told, every refusal with its place."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.errors import RecordingError
from fbfcli.plant.recording import PowerSpectrum, ReadOptions, Recording, ResponseTable
from fbfcli.plant.recordings import read_recordings
from fbfcli.units import GRAVITY

N = 200
RNG = np.random.default_rng(5)
DOWN = np.array([0.0, 0.0, GRAVITY])
SHAKEN = RNG.normal(0.0, 800.0, (N, 3)) + DOWN


def klipper(t=None, a=SHAKEN, head="#time,accel_x,accel_y,accel_z\n", end="\n") -> str:
    t = 531.9 + np.arange(len(a)) / 3210.0 if t is None else t
    return head + end.join(f"{s:.6f},{x:.6f},{y:.6f},{z:.6f}" for s, (x, y, z) in zip(t, a, strict=True)) + end


def read(text: str | bytes, **options):
    data = text if isinstance(text, bytes) else text.encode()
    (one,) = read_recordings(data, "sweep.csv", ReadOptions(**options))
    return one


def refused(text: str | bytes, **options) -> str:
    with pytest.raises(RecordingError) as why:
        read(text, **options)
    said = str(why.value)
    assert said.startswith("sweep.csv") and "\n" not in said and "(" in said
    return said


# kinds

@pytest.mark.parametrize("head", ["#time,accel_x,accel_y,accel_z\n", "time,accel_x,accel_y,accel_z\r\n",
                                  "## measured today\n#time,accel_x,accel_y,accel_z\n", ""])  # fmt: skip
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_klipper_raw(head, end):
    r = read(klipper(head=head, end=end))
    assert (r.kind, r.columns, r.axis) == ("klipper raw", ("x", "y", "z"), None)
    assert r.fs == pytest.approx(3210.0, rel=1e-4)
    assert r.t[0] == 0
    np.testing.assert_allclose(r.measured, SHAKEN, atol=1e-6)


def test_klipper_psd_goes_by_names():
    text = "freq,psd_x,psd_y,accel_per_hz,psd_z,psd_xyz,zv(52.6),3hump_ei(96.2)\n" + "".join(
        f"{f},{f + 1},{f + 2},60,{f + 3},{f + 4},0.5,0.5\n" for f in range(5)
    )
    p = read(text)
    assert isinstance(p, PowerSpectrum)
    assert p.columns == ("x", "y", "z", "xyz")
    assert p.shapers == (("zv", 52.6), ("3hump_ei", 96.2))
    np.testing.assert_array_equal(p.power[2], [3, 4, 5, 6])


def duet(a=SHAKEN, rate="Rate 1341, overflows 0\n") -> str:
    return "Sample,X,Y,Z\n" + "".join(f"{i},{x:.3f},{y:.3f},{z:.3f}\n"
                                      for i, (x, y, z) in enumerate(a / GRAVITY)) + rate  # fmt: skip


def test_duet_is_in_g_and_without_its_first_sample():
    r = read(duet())
    assert (r.kind, r.fs, len(r.t)) == ("duet", 1341.0, N - 1)
    np.testing.assert_allclose(r.measured, SHAKEN[1:], atol=0.5e-3 * GRAVITY)


def test_duet_of_one_axis():
    r = read("Sample,X\n" + "".join(f"{i},{i % 7 / 10}\n" for i in range(50)) + "Rate 1402, overflows 3\n")
    assert r.columns == ("x",)
    assert any("3 times" in note for note in r.notes)


def test_duet_without_its_rate_takes_one_that_is_given():
    assert "--rate" in refused(duet(rate=""))
    assert read(duet(rate=""), rate=1350.0).fs == 1350.0


def test_a_failed_capture_says_so():
    said = refused("Sample,X,Y,Z\nFailed to start accelerometer\n")
    assert "sweep.csv:2:" in said and "Failed to start accelerometer" in said


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "mm/s^2"), (1e3, "m/s^2"), (GRAVITY, "g"), (1e-3 * GRAVITY, "mg")])
def test_units_are_recognised_by_gravity(scale, unit):
    rows = "".join(f"{i / 800},{x},{y},{z}\n" for i, (x, y, z) in enumerate((SHAKEN / scale).tolist()))
    r = read("time,x,y,z\n" + rows)
    np.testing.assert_allclose(r.measured, SHAKEN, atol=1e-6)
    assert any(f"in {unit}:" in note for note in r.notes)


def test_py3dpaxxel():
    rows = "".join(f"00 {i:05d} {x:+09.3f} {y:+09.3f} {z:+09.3f}\n" for i, (x, y, z) in enumerate(SHAKEN / 9.80665))
    r = read("seq sample x y z\n" + rows + "# {'rate': 'ODR3200', 'range': 'G4', 'scale': 'FULL_RES_4MG_LSB'}\n")
    assert (r.kind, r.fs) == ("adxl", 3200.0)
    np.testing.assert_allclose(r.measured, SHAKEN, atol=0.01)
    assert any("nominal" in note for note in r.notes)


def test_without_gravity_the_unit_must_be_told():
    rows = "".join(f"{i / 800},{x},{y},{z}\n" for i, (x, y, z) in enumerate((SHAKEN - DOWN).tolist()))
    assert "--unit" in refused("time,x,y,z\n" + rows)
    assert isinstance(read("time,x,y,z\n" + rows, unit="mm/s^2"), Recording)


def test_a_pair_by_names_and_units():
    rows = "".join(f"{i};{i % 5},5;{i % 3},25\n" for i in range(50))
    r = read("Time [ms];cmd_y [m/s^2];accel_meas_y [m/s^2]\n" + rows)
    assert (r.kind, r.axis, r.columns, r.fs) == ("pair", "y", ("y",), pytest.approx(1000.0))
    np.testing.assert_allclose(r.command[:3], [500.0, 1500.0, 2500.0])
    np.testing.assert_allclose(r.measured[:3, 0], [250.0, 1250.0, 2250.0])


def test_a_pair_by_numbers_of_columns():
    rows = "".join(f"{10 * i}\t0\t{i % 5}\t{i % 4}\t7\n" for i in range(60))
    assert "--command" in refused(rows)
    r = read(rows, time="1", command="3", measured="4")
    assert r.fs == pytest.approx(100.0)
    assert any("in ms" in note for note in r.notes)
    assert "no column '9'" in refused(rows, time="1", command="9", measured="4")
    assert "constant" in refused(rows, time="1", command="2", measured="4")


def test_a_pair_of_two_kinds_is_refused():
    rows = "".join(f"{i / 500} {np.sin(i):.6f} {np.cos(i):.6f}\n" for i in range(100))
    assert "acceleration and position" in refused("t position_command accel_x\n" + rows, command="2", measured="3")


def test_positions_stay_positions():
    rows = "".join(f"{i / 500} {np.sin(i):.6f} {np.sin(i - 0.1):.6f}\n" for i in range(100))
    assert read("t position_command position_actual\n" + rows).quantity == "position"


H = 1.0 / (1.0 - (np.arange(1, 60) / 40.0) ** 2 + 0.1j * np.arange(1, 60) / 40.0)
F = np.arange(1, 60)


@pytest.mark.parametrize(("head", "columns"), [
    ("frequency,magnitude_db,phase_deg", (F, 20 * np.log10(abs(H)), np.degrees(np.angle(H)))),
    ("freq [Hz],gain,phase [rad]", (F, abs(H), np.angle(H))),
    ("f,mag,phase", (F, 20 * np.log10(abs(H)), np.degrees(np.unwrap(np.angle(H))) * 1.0)),
    ("frequency_hz,real,imag", (F, H.real, H.imag)),
    ("omega,re,im", (2 * np.pi * F, H.real, H.imag)),
])  # fmt: skip
def test_response_tables(head, columns):
    text = head + "\n" + "\n".join(",".join(f"{v:.9f}" for v in row) for row in zip(*columns, strict=True)) + "\n"
    table = read(text)
    assert isinstance(table, ResponseTable) and table.has_phase
    np.testing.assert_allclose(table.frequency, F, rtol=1e-6)
    np.testing.assert_allclose(table.response, H, rtol=1e-5)


def test_a_response_without_phase_says_so():
    assert not read("freq,gain\n" + "".join(f"{f},{abs(h)}\n" for f, h in zip(F, H, strict=True))).has_phase


SWEEP_CFG = {"a": "4000", "dfdt": "4", "dly1_ti": "500", "dly2_ti": "1000", "dly3_ti": "1000", "f0": "5", "f1": "80",
             "step_a": "4000", "step_ti": "50"}  # fmt: skip


def ulendo(**changed) -> str:
    axes = {f"{axis}AXISRESPONSE": base64.b64encode(SHAKEN[:, i].astype("<f4").tobytes()).decode()
            for i, axis in enumerate("XYZ")}  # fmt: skip
    return json.dumps({"AXIS": "y", "SWEEP_CFG": SWEEP_CFG, **axes} | changed)


def test_ulendo():
    r = read(ulendo())
    assert (r.kind, r.axis) == ("ulendo", "y")
    assert r.sweep.duration == pytest.approx(21.9)
    np.testing.assert_allclose(r.measured, SHAKEN, rtol=1e-6)


@pytest.mark.parametrize("changed", [{"SWEEP_CFG": {"f0": "5"}}, {"SWEEP_CFG": 3},
                                     {"SWEEP_CFG": SWEEP_CFG | {"a": "x"}},
                                     {"XAXISRESPONSE": "A"}, {"YAXISRESPONSE": "AAAAAA=="}, {"ZAXISRESPONSE": 4},
                                     {"SWEEP_CFG": SWEEP_CFG | {"dfdt": "0"}}])  # fmt: skip
def test_ulendo_refused(changed):
    refused(ulendo(**changed))


# oddities

def test_the_true_rate_is_found_under_jitter():
    t = np.cumsum(np.full(5000, 1 / 1573.0)) + RNG.normal(0, 1e-4, 5000)
    t = np.maximum.accumulate(t)
    r = read(klipper(t, RNG.normal(0, 500, (5000, 3)) + DOWN))
    assert r.fs == pytest.approx(1573.0, rel=1e-4)


def test_gaps_are_told_with_their_place():
    t = np.arange(N) / 1000.0
    t[120:] += 0.05
    r = read(klipper(t))
    assert r.fs == pytest.approx(1000.0, rel=1e-3)
    assert any("1 gap, 50 samples missing" in note and "line 122" in note for note in r.notes)


def test_backward_time_is_refused_with_its_line():
    t = np.arange(N) / 1000.0
    t[100] = 0.01
    assert "sweep.csv:102:" in refused(klipper(t))


def test_repeated_times_are_left_out_and_told():
    t = np.arange(N) / 1000.0
    t[50] = t[49]
    r = read(klipper(t))
    assert len(r.t) == N - 1
    assert any("line 52" in note for note in r.notes)


def test_times_of_batches_are_spread():
    t = np.repeat(np.arange(N // 10) * 0.01, 10)
    r = read(klipper(t))
    assert r.fs == pytest.approx(1000.0)
    assert any("batches of 10" in note for note in r.notes)


def test_clipping_is_told():
    a = SHAKEN.copy()
    a[:, 0] = np.clip(3e5 * np.sin(np.arange(N) / 15), -16 * GRAVITY, 16 * GRAVITY)
    notes = read(klipper(a=a)).notes
    assert any("x is clipped at the top (+16.0 g)" in note for note in notes)
    assert any("x is clipped at the bottom" in note for note in notes)


@pytest.mark.parametrize(("degrees", "told"), [(2.0, False), (30.0, True)])
def test_tilt_is_told(degrees, told):
    rest = GRAVITY * np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    notes = read(klipper(a=RNG.normal(0, 30, (N, 3)) + rest)).notes
    assert any("tilted by 30" in note for note in notes) == told


def test_a_last_row_that_is_cut_off_is_left_out_and_told():
    r = read(klipper()[:-25])
    assert len(r.t) == N - 1
    assert any(f"line {N + 1}" in note for note in r.notes)


# refusals

@pytest.mark.parametrize("data", [b"", b"\n\n", b"\xef\xbb\xbf", b"#time,accel_x,accel_y,accel_z\n", b"hello\n",
                                  b"GCDE\0\0\0", b"\0" * 100, b"{", b"[1, 2]", b'{"a": 1}', b"1,2,3,4\n",
                                  b"time,x\n1,2\n",
                                  b"G1 X1 Y2\nG1 X3 Y4\n"])  # fmt: skip
def test_what_is_no_recording_is_refused(data):
    refused(data)


def test_a_broken_row_is_named():
    rows = klipper().splitlines()
    rows[77] = "1.0,2.0,oops,4.0"
    assert "sweep.csv:78:" in refused("\n".join(rows))
    rows[77] = "1.0,2.0,4.0"
    assert "sweep.csv:78:" in refused("\n".join(rows))
    rows[77] = "1.0,2.0,nan,4.0"
    assert "sweep.csv:78:" in refused("\n".join(rows))


@given(st.binary(max_size=400))
def test_any_bytes_end_in_one_error_or_a_recording(data):
    try:
        read_recordings(data, "sweep.csv")
    except RecordingError as why:
        assert "\n" not in str(why)


VALID = [klipper(a=SHAKEN[:40]).encode(), duet(SHAKEN[:40]).encode(), ulendo().encode()[:3000],
         b"freq,psd_x,psd_xyz\n1,2,3\n2,3,4\n", b"freq,mag,phase\n1,1,0\n2,2,-1\n3,1,-2\n",
         b"time,cmd,meas\n" + b"".join(b"%d,%d,%d\n" % (i, i % 3, i % 5) for i in range(40))]  # fmt: skip


@given(st.sampled_from(VALID), st.lists(st.tuples(st.integers(0, 10_000), st.binary(max_size=6)), max_size=5))
def test_a_damaged_file_ends_in_one_error_or_a_recording(data, damages):
    for place, bytes_ in damages:
        at = place % len(data)
        data = data[:at] + bytes_ + data[at + len(bytes_) // 2 :]
    try:
        for one in read_recordings(data, "sweep.csv"):
            if isinstance(one, Recording):
                assert np.isfinite(one.fs) and one.fs > 0 and (np.diff(one.t) > 0).all()
                assert one.measured.shape == (len(one.t), len(one.columns))
    except RecordingError as why:
        assert "\n" not in str(why)
