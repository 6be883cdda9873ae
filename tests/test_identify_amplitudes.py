"""A machine that is softer when it is shaken harder (Ramani 2020b, Fig. 4): a model for each amplitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from simulated_recordings import Sensor, modal, recorded

from fbfcli.cli.lookup import bundled
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.excite import excite
from fbfcli.pipeline.identify import identify_captures
from fbfcli.plant.sweep_spec import sweep_of_csv
from fbfcli.printer import Family, Mode
from fbfcli.printer_toml import parse_printer
from fbfcli.profile_text import new_profile, with_model

TRUTH = {2000.0: Mode(42.0, 0.05), 3500.0: Mode(39.0, 0.065), 5000.0: Mode(37.0, 0.08)}  # by amplitude [mm/s^2]
SENSOR = Sensor(fs=800.0, clock_error=2e-3, noise=0.05)  # slower than real ones, to be quick


@pytest.fixture(scope="module")
def found():
    """What is identified of one run of `fbf excite`'s sweep at three amplitudes, on a machine that softens."""
    made = excite(bundled()["synthetic_bed_slinger"], "x", 5.0, 60.0, 6.0, tuple(TRUTH))
    sweep = sweep_of_csv(made.command.encode(), "sweep_x.csv")
    # the same start and noise each time, and rest between the amplitudes: there one machine becomes the next
    one, *others = (recorded(sweep, modal([mode]), SENSOR, "x", np.random.default_rng(1)) for mode in TRUTH.values())
    start = np.random.default_rng(1).uniform(0.3, 1.5)
    measured = one.measured.copy()
    for (begin, _, _), other in zip(sweep.segments[1:], others, strict=True):
        later = one.t > start + begin - 0.5
        measured[later] = other.measured[later]
    return identify_captures([replace(one, measured=measured)], Ask(axis="x", sweep=sweep))


def test_each_amplitude_has_its_own_model(found):
    assert isinstance(found.spread, Family)
    members = [max(model.modes, key=lambda mode: mode.gain / mode.damping) for model in found.spread.models]
    assert [m.frequency for m in members] == pytest.approx([m.frequency for m in TRUTH.values()], rel=0.005)
    assert [m.damping for m in members] == pytest.approx([m.damping for m in TRUTH.values()], rel=0.1)


def test_the_amplitudes_are_told_by_name_and_that_they_differ(found):
    labels = [label for label, _ in found.measured.groups]
    assert [label.rpartition(" at ")[2] for label in labels] == ["2000 mm/s^2", "3500 mm/s^2", "5000 mm/s^2"]
    assert any("moves between" in hint and "friction" in hint for hint in found.hints)


def test_the_family_goes_into_the_profile_and_the_model_lies_within_it(found):
    text = with_model(new_profile("soft", "x"), "p.toml", "x", found.model, found.spread, found.note())
    axis = parse_printer(text, "p.toml").axes[0]
    assert isinstance(axis.uncertainty, Family) and len(axis.uncertainty.models) == len(TRUTH)
    frequencies = [mode.frequency for mode in TRUTH.values()]
    assert min(frequencies) < found.modes[0].frequency.value < max(frequencies)


def test_as_ranges_it_reaches_as_far(found):
    low, high = found.ranges.frequency
    frequencies = np.array([mode.frequency for mode in TRUTH.values()]) / found.modes[0].frequency.value
    assert (low, high) == pytest.approx((frequencies.min(), frequencies.max()), rel=0.01)
