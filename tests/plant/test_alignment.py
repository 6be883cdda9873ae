"""The command rebuilt, and put on the clock of the measurement: machines of known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from resonance_corpus import RESONANCE, needs_resonance
from simulated_recordings import Sensor, as_klipper_csv, drawn_sensor, modal, recorded

from fbfcli.cli.lookup import find_printer
from fbfcli.errors import RecordingError
from fbfcli.pipeline.excite import excite
from fbfcli.plant.alignment import paired
from fbfcli.plant.chirps import ulendo_sweep
from fbfcli.plant.klipper_test import klipper_test, klipper_test_2020
from fbfcli.plant.recording import Recording
from fbfcli.plant.recordings import read_recordings
from fbfcli.plant.sweep_spec import sweep_of_csv
from fbfcli.printer import Mode

ONE, TWO = modal([Mode(42.0, 0.05)]), modal([Mode(38.0, 0.06, 0.7), Mode(66.0, 0.04, 0.3)])
FS = 800.0  # Hz: slower than real sensors, to be quick
PPM = 1e-6


def own_sweep():
    made = excite(find_printer("synthetic_bed_slinger"), "x", 5.0, 60.0, 6.0, (2000.0, 5000.0))
    return sweep_of_csv(made.command.encode(), "sweep_x.csv")


SWEEPS = {
    "klipper": klipper_test(f1=70.0),
    "klipper without the slow wave": klipper_test(f1=70.0, sweeping_period=0.0),
    "klipper before 2025": klipper_test_2020(f1=70.0),
    "ours": own_sweep(),
    "ulendo": ulendo_sweep(5.0, 80.0, 4.0, 4000.0, 0.05, 4000.0, 0.5, 1.0, 1.0),
}


def simulated(sweep, response=ONE, seed=1, **changed) -> tuple[Recording, Sensor]:
    rng = np.random.default_rng(seed)
    sensor = replace(drawn_sensor(rng), fs=FS, **changed)
    return recorded(sweep, response, sensor, "x", rng), sensor


def response_of(pair):
    """H and coherence by Welch's method at frequencies [Hz]."""
    from scipy.signal import csd, welch

    n = int(4 * pair.fs)
    y = pair.response[:, pair.columns.index(pair.axis)]
    f, S_uy = csd(pair.command, y, pair.fs, nperseg=n)
    S_uu, S_yy = (welch(v, pair.fs, nperseg=n)[1] for v in (pair.command, y))
    return f, S_uy / S_uu, np.abs(S_uy) ** 2 / (S_uu * S_yy)


@pytest.mark.parametrize("sweep", SWEEPS.values(), ids=SWEEPS)
@pytest.mark.parametrize("response", [ONE, TWO], ids=["one mode", "two modes"])
def test_clock_and_response_are_found(sweep, response):
    """Clock to 40 ppm: over a minute of sweep 2.4 ms; the response as it is, but for a delay of a part of a sample."""
    recording, sensor = simulated(sweep, response, seed=len(sweep.name))
    pair = paired(recording, sweep, "x")
    assert pair.clock * (1 + sensor.clock_error) == pytest.approx(1.0, abs=40 * PPM)
    assert pair.correlation > 0.9
    f, H, coherence = response_of(pair)
    band = (coherence > 0.9) & (f > 6) & (f < 55)
    ratio = H[band] / response(f[band])
    delay = -np.sum(f[band] * np.unwrap(np.angle(ratio))) / np.sum(2 * np.pi * f[band] ** 2)
    assert abs(delay) < 2e-3
    turned = ratio * np.exp(2j * np.pi * f[band] * delay)
    assert np.percentile(np.abs(turned - 1), 90) < 0.1


def test_klippers_defaults_are_tried_and_the_end_is_found():
    recording, _ = simulated(klipper_test(f1=50.0))
    pair = paired(recording, axis="x")
    assert pair.sweep.name == klipper_test().name
    assert pair.sweep.duration == pytest.approx(klipper_test(f1=50.0).duration, abs=0.6)
    assert pair.sweep.f1 == pytest.approx(50.0, abs=0.7)


def test_another_amplitude_than_the_default_is_found():
    recording, _ = simulated(klipper_test(f1=50.0, accel_per_hz=90.0, sweeping_period=0.0))
    pair = paired(recording, axis="x")
    f, H, _ = response_of(pair)
    assert np.abs(H[(f > 6) & (f < 10)]).mean() == pytest.approx(np.abs(ONE(np.array([8.0])))[0], rel=0.1)
    assert any("times the default" in note for note in pair.notes)


def test_a_sensor_upside_down_is_turned():
    sweep = klipper_test(f1=40.0)
    recording, _ = simulated(sweep)
    pair = paired(recording, sweep, "x")
    turned = paired(replace(recording, measured=-recording.measured), sweep, "x")
    np.testing.assert_allclose(turned.response, pair.response, atol=1e-6)
    assert any("upside down" in note for note in turned.notes)


def test_a_pair_stays_as_it_is_but_for_the_mean():
    t = np.arange(500) / 1000.0
    y = np.sin(90 * t)[:, None] + 7.0
    pair = paired(Recording("pair", "x.csv", 1000.0, t, y, ("x",), np.cos(90 * t), "x"))
    np.testing.assert_array_equal(pair.command, np.cos(90 * t))
    np.testing.assert_allclose(pair.response, y - y.mean())
    assert (pair.delay, pair.clock, pair.correlation) == (0.0, 1.0, 1.0)


def test_gaps_are_bridged():
    t = np.delete(np.arange(1000) / 1000.0, slice(300, 320))
    pair = paired(Recording("pair", "x.csv", 1000.0, t, np.sin(20 * t)[:, None], ("x",), np.sin(20 * t), "x"))
    assert len(pair.command) == 1000
    np.testing.assert_allclose(pair.command, np.sin(20 * np.arange(1000) / 1000), atol=0.05)


def test_amplitudes_are_kept_apart():
    sweep = SWEEPS["ours"]
    recording, _ = simulated(sweep)
    pair = paired(recording, sweep, "x")
    assert [size for _, _, size in pair.segments] == [2000.0, 5000.0]
    for begin, end, size in pair.segments:
        assert np.sqrt(np.mean(pair.command[begin:end] ** 2)) == pytest.approx(size, rel=0.05)


REST = Recording("klipper raw", "rest.csv", FS, np.arange(8000) / FS,
                 np.random.default_rng(2).normal(0, 100, (8000, 3)), ("x", "y", "z"))  # fmt: skip


@pytest.mark.parametrize(("recording", "sweep", "axis", "told"), [
    (REST, None, "x", "is not found"),
    (REST, SWEEPS["ulendo"], "x", "is not found"),
    (REST, None, None, "--axis"),
    (replace(REST, columns=("x", "z", "xyz")), None, "y", "no measurement of axis y"),
    (replace(REST, kind="duet"), None, "x", "--sweep"),
    (replace(REST, axis="y"), None, "x", "says that y was moved"),
    (replace(REST, t=REST.t[:900], measured=REST.measured[:900]), None, "x", "too short"),
    (replace(REST, measured=0 * REST.measured), None, "x", "is not found"),
])  # fmt: skip
def test_what_cannot_be_aligned_is_refused(recording, sweep, axis, told):
    with pytest.raises(RecordingError, match=told) as why:
        paired(recording, sweep, axis)
    assert str(why.value).startswith("rest.csv: ")


def test_a_recording_as_text_is_the_recording():
    recording, _ = simulated(klipper_test(f1=8.0))
    (back,) = read_recordings(as_klipper_csv(recording), "raw_data_x.csv")
    assert back.fs == pytest.approx(recording.fs, rel=1e-4)
    np.testing.assert_allclose(back.measured, recording.measured, atol=1e-5)


@needs_resonance
def test_ulendo_alone_gives_its_pair():
    """The published pair, from the request alone: rate 1573.00 Hz, lag 912 samples, that pair's by whole samples."""
    (request,) = read_recordings((RESONANCE / "ulendo/ender3v2neo_y_240529_143933.json").read_bytes(), "request.json")
    pair = paired(request)
    assert pair.axis == "y"
    assert pair.fs == pytest.approx(1573.0, abs=0.2)
    assert pair.delay == pytest.approx(-912 / 1573.0, abs=3e-3)
    assert pair.correlation > 0.95
