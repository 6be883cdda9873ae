"""Recordings that people made: what each is, and the one error of those that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from resonance_corpus import RESONANCE, needs_resonance

from fbfcli.errors import RecordingError
from fbfcli.plant.recording import PowerSpectrum, ReadOptions, Recording, ResponseTable
from fbfcli.plant.recordings import read_recordings

pytestmark = needs_resonance
FILES = sorted(RESONANCE.glob("*/*"))
REFUSED = {
    "owendare_0_2022-12-31_22.38.47.csv": ":2: the capture failed: 'Failed to start accelerometer'",
    "oernster_inputshaper_20240830_181255_X_EMPTY.csv": ":1: no numbers in it",
    "camber_LinA_pp-sine-sweep-10mm-0.5Hz.txt": ":1: 6 columns without names",
}
RATES = {  # Hz, of the sensors' own clocks
    "ulendo_ender3v2neo_y_240529_143933_paired.csv": 1573.0,
    "gixxerfast_voron2_121_2021-10-02_23.19.29.csv": 1341.0,
    "beattune_raw_data_x_lis2dw_20260423_171429_FIRST60.csv": 1605.7,
    "ofri_adxl345-belt_A_1.csv": 3209.7,
    "ofri_adxl345-shake_a_oscillation.csv": 3215.6,
}


def read(file: Path, **options):
    (one,) = read_recordings(file.read_bytes(), file.name, ReadOptions(**options))
    return one


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_file_is_read_or_refused_in_one_line(file):
    if file.name in REFUSED:
        with pytest.raises(RecordingError) as why:
            read(file)
        assert str(why.value).startswith(file.name + REFUSED[file.name])
        return
    one = read(file)
    if isinstance(one, Recording):
        assert one.measured.shape == (len(one.t), len(one.columns))
        assert one.fs == pytest.approx(RATES.get(file.name, one.fs), abs=0.1)
        if file.parent.name in ("klipper_raw", "duet", "py3dpaxxel", "ulendo") and len(one.columns) == 3:
            rest = float(np.linalg.norm(np.median(one.measured, axis=0)))
            assert 8500 < rest < 11_500  # mm/s^2: the units are right, for gravity is in
    else:
        assert isinstance(one, PowerSpectrum | ResponseTable)
        assert (np.diff(one.frequency) > 0).all()


def test_a_log_without_names_is_read_by_the_numbers_of_its_columns():
    log = read(RESONANCE / "commanded_measured" / "camber_LinA_pp-sine-sweep-10mm-0.5Hz.txt", time="1", command="3",
               measured="4")  # fmt: skip
    assert log.fs == pytest.approx(100.0)
    assert np.corrcoef(log.command, log.measured[:, 0])[0, 1] > 0.99
