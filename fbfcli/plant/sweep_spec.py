"""Tests as people name them: klipper, klipper:f1=100,accel_per_hz=75, marlin, ulendo; or the CSV of `fbf excite`."""

from __future__ import annotations

import re
from collections.abc import Callable
from difflib import get_close_matches
from inspect import signature
from math import isfinite

import numpy as np

from fbfcli.errors import RecordingError
from fbfcli.plant.chirps import HIGHEST, RUN_IN, marlin_test, ulendo_sweep
from fbfcli.plant.excitation import Sweep, piecewise
from fbfcli.plant.klipper_test import klipper_test, klipper_test_2020
from fbfcli.plant.text_table import read_table, text_of

TESTS: dict[str, Callable[..., Sweep]] = {
    "klipper": klipper_test,
    "klipper-2020": klipper_test_2020,
    "marlin": marlin_test,
    "ulendo": ulendo_sweep,
}
HELD = "each value holds until the next row's time"
SWEPT = "sweep of {:g} mm/s2 from {:.2f} to {:.2f} Hz, from {:.4f} to {:.4f} s"  # a comment of the CSV for each
READ = re.compile(r"sweep of (\d+\.?\d*) mm/s2 from (\d+\.?\d*) to (\d+\.?\d*) Hz, from (\d+\.?\d*) to (\d+\.?\d*) s")
LOWEST = 0.5  # Hz, of a sweep
UNSAID = (5.0, 200.0)  # Hz, of a command that somebody else sampled


def named_sweep(words: str) -> Sweep:
    """The test that `name` or `name:key=value,...` names. RecordingError with what would be right."""
    name, _, settings = words.partition(":")
    if name not in TESTS:
        near = get_close_matches(name, TESTS, n=1)
        raise RecordingError(f"no test {name!r}", remedy=f"did you mean {near[0]}?" if near else
                             f"known are {', '.join(TESTS)}, or the CSV that `fbf excite` wrote")  # fmt: skip
    keys = list(signature(TESTS[name]).parameters)
    given: dict[str, float] = {}
    for setting in filter(None, settings.split(",")):
        key, _, value = (part.strip() for part in setting.partition("="))
        if key not in keys:
            raise RecordingError(f"{name} has no {key!r}", remedy=f"it has {', '.join(keys)}")
        try:
            given[key] = float(value)
        except ValueError:
            raise RecordingError(f"{key} of {name} is no number: {value!r}", remedy=f"such as {key}=5") from None
        if not isfinite(given[key]) or given[key] < 0:
            raise RecordingError(f"{key} of {name} must not be {value}", remedy=f"such as {key}=5")
    missing = [key for key, one in signature(TESTS[name]).parameters.items()
               if one.default is one.empty and key not in given]  # fmt: skip
    if missing:
        raise RecordingError(f"{name} needs {', '.join(missing)}", remedy=f"such as {name}:{missing[0]}=5,...")
    return _checked(name, given)


def _checked(name: str, given: dict[str, float]) -> Sweep:
    """The test, if its frequencies rise."""
    settings = {key: one.default for key, one in signature(TESTS[name]).parameters.items()} | given
    rising = all(settings.get(key, 1.0) > 0 for key in ("hz_per_sec", "dfdt", "octave"))
    lowest = RUN_IN if name == "ulendo" else LOWEST
    if not (rising and lowest < settings["f0"] < settings["f1"] <= HIGHEST):
        raise RecordingError(f"the frequency of {name} must rise, from {lowest:g} Hz or more to {HIGHEST:g} Hz or less",
                             remedy=f"such as {name}:f0=5,f1=100")  # fmt: skip
    return TESTS[name](**given)


def sweep_csv(edge: np.ndarray, a: np.ndarray, axis: str, about: list[str]) -> str:
    """Accelerations `a` from each `edge` on, shape (m,), as text; `about`: comments."""
    rows = [f"{t:.7f},{value:.3f}" for t, value in zip(edge.tolist(), a.tolist(), strict=True)]
    head = [f"# {line}" for line in (*about, HELD)]
    return "\n".join([*head, f"time_s,accel_cmd_{axis}_mm/s2", *rows, ""])


def sweep_of_csv(data: bytes, name: str) -> Sweep:
    """The command that a CSV of time and acceleration holds: written by `sweep_csv`, or sampled evenly by anything."""
    table = read_table(text_of(data, name), name)
    if table.values.shape[1] != 2:
        raise table.error("a command has two columns, time and acceleration", 0, "give the CSV of `fbf excite`")
    t, a = table.values.T
    step = np.diff(t)
    for row in np.flatnonzero(step <= 0)[:1]:
        raise table.error("time does not rise", int(row) + 1, "cut the line out")
    if len(t) < 3 or not a.any():
        raise table.error("it commands nothing", 0, "give the CSV of `fbf excite`")
    if HELD not in table.comments:  # samples: the mean of a period around each
        t, step = t - 0.5 * step[0], np.append(step, step[-1])[: len(step)]
    told = [tuple(map(float, found.groups())) for found in map(READ.fullmatch, table.comments) if found]
    f0 = min((one[1] for one in told), default=UNSAID[0])
    f1 = max((one[2] for one in told), default=UNSAID[1])
    segments = tuple((begin, end, size) for size, _, _, begin, end in told)
    return Sweep(f"the sweep of {name}", float(t[-1] - t[0]), f0, f1, piecewise(step, a[:-1]), segments)
