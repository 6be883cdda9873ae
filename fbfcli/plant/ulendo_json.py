"""Ulendo CaaS: a request with three axes of float32 samples and the sweep that was commanded, or its answer.

https://github.com/S2AUlendo/UlendoCaaS
"""

from __future__ import annotations

import base64
import binascii
import json
from math import isfinite
from typing import Any

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.chirps import HIGHEST, RUN_IN, ulendo_sweep
from fbfcli.plant.recording import Read, Recording, ResponseTable
from fbfcli.plant.sensor import oddities

NOMINAL = 1600.0  # Hz: what the plug-in sets; the sensor's own clock is up to some per cent off
MS_PER_S = 1e3
TURN = 2 * np.pi
SWEEP_KEYS = ("f0", "f1", "dfdt", "a", "step_ti", "step_a", "dly1_ti", "dly2_ti", "dly3_ti")


def ulendo(text: str, name: str) -> Read:
    """The recording of a request, or the response of an answer."""
    try:
        whole = json.loads(text)
    except ValueError as why:
        raise RecordingError(f"not JSON: {why}", file=name, remedy="is the file complete?") from None
    if isinstance(whole, dict) and "SWEEP_CFG" in whole:
        return _request(whole, name)
    if isinstance(whole, dict) and "gui_data" in whole:
        return _answer(whole, name)
    raise RecordingError("is JSON, but no request or answer of Ulendo CaaS", file=name, remedy="give the recording")


def _request(whole: dict[str, Any], name: str) -> Recording:
    settings = whole["SWEEP_CFG"]
    try:
        given = {key: float(settings[key]) for key in SWEEP_KEYS}
    except (KeyError, TypeError, ValueError) as why:
        raise RecordingError(f"SWEEP_CFG does not define the sweep: {why}", file=name, remedy="record again") from None
    if not (all(map(isfinite, given.values())) and min(given.values()) >= 0 and given["dfdt"] > 0
            and RUN_IN < given["f0"] < given["f1"] < HIGHEST):  # fmt: skip
        raise RecordingError(f"SWEEP_CFG is no sweep: {settings}", file=name, remedy="frequencies must rise")
    for key in [key for key in given if key.endswith("_ti")]:
        given[key] /= MS_PER_S
    axes = {axis: _samples(whole, f"{axis.upper()}AXISRESPONSE", name) for axis in "xyz"}
    lengths = {len(values) for values in axes.values()}
    if len(lengths) > 1 or min(lengths) == 0:
        raise RecordingError(f"the axes hold {sorted(lengths)} samples", file=name, remedy="record again")
    measured = np.column_stack(list(axes.values()))
    if not np.isfinite(measured).all():
        raise RecordingError("a sample is not finite", file=name, remedy="record again")
    axis = str(whole.get("AXIS", "")).lower()
    n = len(measured)
    notes = (f"the rate is the nominal {NOMINAL:g} Hz until it is aligned",
             *oddities(measured, ("x", "y", "z"), np.arange(1, n + 1)))  # fmt: skip
    return Recording("ulendo", name, NOMINAL, np.arange(n) / NOMINAL, measured, ("x", "y", "z"),
                     axis=axis if axis in ("x", "y") else None, sweep=ulendo_sweep(**given), notes=notes)  # fmt: skip


def _samples(whole: dict[str, Any], key: str, name: str) -> np.ndarray:
    """Little-endian float32 [mm/s^2] in base64."""
    try:
        raw = base64.b64decode(whole[key], validate=True)
        return np.frombuffer(raw, "<f4").astype(float)
    except (KeyError, TypeError, binascii.Error, ValueError) as why:
        raise RecordingError(f"{key} holds no samples: {why}", file=name, remedy="record again") from None


def _answer(whole: dict[str, Any], name: str) -> ResponseTable:
    """Gain at angular frequencies; phase is not told."""
    try:
        told = json.loads(whole["gui_data"])
        frequency, gain = np.array(told["bp"], float) / TURN, np.array(told["g"], float)
    except (KeyError, TypeError, ValueError) as why:
        raise RecordingError(f"gui_data holds no response: {why}", file=name, remedy="give the recording") from None
    if len(frequency) != len(gain) or len(gain) < 2:
        raise RecordingError("bp and g differ in length", file=name, remedy="give the recording")
    axis = str(whole.get("AXIS", "")).lower()
    return ResponseTable(name, frequency, gain, has_phase=False, axis=axis if axis in ("x", "y") else None)
