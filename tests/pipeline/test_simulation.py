"""A simulated print obeys the laws of what it simulates."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from print_cases import RIGID, SOFT, START, compensated, end_of, print_time, printer, prints, read

from fbfcli.errors import ModelError
from fbfcli.gcode.scan import chunks
from fbfcli.pipeline import Settings
from fbfcli.pipeline.simulate import FIRMWARE, Wanted, simulate
from fbfcli.pipeline.simulation import Simulation
from fbfcli.printer import Limits, ModalModel, Mode, Place, Printer, Spread
from fbfcli.verify.passage import Passage

ROUNDING = 1e-9  # mm, of positions up to 1000 mm
LINE = "G90\nM83\nG1 X120 Y120 F6000\nG1 X130 Y90 E1\n"
ZIGZAG = "".join(f"G1 X{100 + 60 * (i % 2)} Y{103 + 3 * i} E1 F9000\n" for i in range(20))
TWO_LAYERS = (
    f"{START}G4 P500\n;LAYER_CHANGE\n;TYPE:wall\n{ZIGZAG}G1 E-1 F2400\nG1 Z0.6 F900\n"
    f";LAYER_CHANGE\n;TYPE:infill\nG4 P200\nG1 E1 F2400\n{ZIGZAG}"
)


class Seen:
    """Everything a watcher is told."""

    def __init__(self) -> None:
        self.passages: dict[str, list[Passage]] = {}
        self.starts: dict[str, list[np.ndarray]] = {}
        self.features: Sequence[str] = ()

    def begin(self, name: str, features: Sequence[str]) -> None:
        self.features = features

    def add(self, name: str, passage: Passage) -> None:
        self.passages.setdefault(name, []).append(passage)

    def segments(self, name: str, starts: np.ndarray) -> None:
        self.starts.setdefault(name, []).append(starts)

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        pass

    def row(self, method: str, column: str) -> np.ndarray:
        return np.concatenate(
            [getattr(p if hasattr(p, column) else p.execution, column) for p in self.passages[method]]
        )


def simulated(
    text: str | bytes, wanted_for: Printer, how: Settings | None = None, size: int = 1 << 19, **wanted
) -> tuple[Simulation, Seen]:
    source, seen = text.encode() if isinstance(text, str) else text, Seen()
    done = simulate(
        lambda: chunks(io.BytesIO(source), size), wanted_for, how or Settings(), Wanted(**wanted), watchers=[seen]
    )
    return done, seen


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
@settings(max_examples=8)
@given(text=prints("klipper"))
def test_a_rigid_machine_draws_what_is_asked_for(rate, text):
    done, seen = simulated(text, printer("klipper", RIGID), methods=("none",), rate=rate)
    assert np.abs(seen.row("none", "tracking")).max(initial=0.0) <= ROUNDING
    assert done.results[0].figures[0].total.contour.max <= 1e3 * ROUNDING


@settings(max_examples=8)
@given(text=prints("klipper", ("print", "travel", "retract", "fan")))
def test_a_rigid_machine_draws_what_is_executed_of_any_method(text):
    text += LINE
    _, seen = simulated(text, printer("klipper"), methods=("zv",), machine=printer("klipper", RIGID), rate=2000.0)
    motion, nozzle = seen.row("zv", "motion"), seen.row("zv", "nozzle")
    assert np.abs(motion[:, :2] - nozzle).max(initial=0.0) <= ROUNDING


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_the_ringing_after_a_stop_is_the_plants(rate):
    """A stop from full speed at once: maxima come each damped period, each exp(-2 pi zeta / sqrt(1 - zeta^2)) of the
    one before, and the first is as high as that of the plant's answer to a ramp that ends."""
    f, zeta, v = 25.0, 0.08, 100.0
    machine = replace(printer("klipper", ModalModel((Mode(f, zeta),))), limits=SUDDEN)
    text = f"G28\nG90\nM83\nG1 X1 F{60 * v}\nG1 X101\nG1 E1 F60\n"
    done, seen = simulated(text, machine, methods=("none",), rate=rate)
    x, there = seen.row("none", "nozzle")[:, 0], seen.row("none", "desired")[:, 0] == 101.0
    ringing = x[there] - 101.0
    peak = np.flatnonzero((ringing[1:-1] > ringing[:-2]) & (ringing[1:-1] > ringing[2:])) + 1
    damped = f * np.sqrt(1 - zeta**2)
    assert np.diff(peak)[:8] / rate == pytest.approx(1 / damped, abs=1.01 / rate)
    heights = ringing[peak][:6]
    assert heights[1:] / heights[:-1] == pytest.approx(np.exp(-2 * np.pi * zeta * f / damped), rel=0.03)
    w, t = 2 * np.pi * f, np.arange(0, 0.1, 1e-5)  # y - r of a ramp that stops: v / w_d exp(-zeta w t) sin(w_d t + ...)
    delayed = 2 * zeta / w
    w_d = 2 * np.pi * damped
    after = v * np.exp(-zeta * w * t) * (delayed * np.cos(w_d * t) + (zeta * w * delayed - 1) / w_d * np.sin(w_d * t))
    assert heights[0] == pytest.approx(np.max(-after), rel=0.02)
    assert done.results[0].time == pytest.approx(print_time(text, machine), abs=0.01)


SUDDEN = Limits(
    velocity=1000.0, acceleration=1e7, travel_acceleration=1e7, retract_acceleration=1e4,
    axis_velocity=(1000.0, 1000.0, 20.0, 80.0), axis_acceleration=(1e7, 1e7, 500.0, 5000.0),
)  # fmt: skip


@pytest.mark.parametrize("method", ["zv", "lpfbs"])
def test_the_written_file_is_what_is_judged(method):
    """What `compensate` writes, read back and executed as it is written, is where the motors were taken to be."""
    machine, text = printer("klipper"), "G28\nG90\nM83\nG1 X100 Y100 F6000\nG4 P100\n" + ZIGZAG
    done, of_original = simulated(text, machine, methods=(method,))
    made_for = [one.frequency for one in done.results[0].made_for]
    written = compensated(text, machine, Settings(method=method, shaped=tuple(made_for) or None))
    _, of_written = simulated(written.text, machine, methods=("none",))
    here, there = of_original.row(method, "motion"), of_written.row("none", "motion")
    there = there[np.flatnonzero(np.diff(of_written.row("none", "time")) > 0.05)[0] + 1 :]
    n = min(len(here), len(there))
    assert abs(len(here) - len(there)) <= 1
    assert np.abs(here[:n, :3] - there[:n, :3]).max() < 1e-5  # mm


@settings(max_examples=8)
@given(text=prints("klipper", ("print", "travel", "retract", "lift", "fan", "wait", "feed")), many=st.integers(1, 3))
def test_nothing_is_lost_between_file_and_machine(text, many):
    """Ends, filament, and time are those of the file; samples are one period apart, or a rest."""
    machine, text = printer("klipper"), text + LINE
    done, seen = simulated(text, machine, methods=("none", "zv"), rate=1000.0 * many, size=700)
    moves = read(text, machine).moves
    end = end_of(moves)
    for one in done.results:
        motion, time = seen.row(one.name, "motion"), seen.row(one.name, "time")
        step = np.diff(time) * 1000 * many
        assert (step > -1e-6).all() and np.abs(step - np.rint(step)).max(initial=0.0) < 1e-6
        assert time[-1] <= one.time + 1e-3 * (1 + text.count("\n"))
        assert set(seen.row(one.name, "line").tolist()) <= set(moves.line.tolist())
        assert motion[-1, :2] == pytest.approx(end[:2], abs=2e-5)
    assert seen.row("none", "motion")[-1] == pytest.approx(end, abs=1e-9)


def test_methods_in_one_run_are_the_methods_alone():
    machine, methods = printer("klipper"), ("none", "mzv", FIRMWARE + "ei", "contour")
    together, _ = simulated(TWO_LAYERS, machine, methods=methods, mismatches=(0.1,))
    assert len(together.results) == len(methods)
    for method, one in zip(methods[1:], together.results[1:], strict=True):
        alone, _ = simulated(TWO_LAYERS, machine, methods=(method,), mismatches=(0.1,))
        assert one.as_dict(together.conditions, together.features) == alone.results[0].as_dict(
            alone.conditions, alone.features
        )


def test_chunks_change_nothing():
    machine = printer("klipper")
    whole, _ = simulated(TWO_LAYERS, machine, methods=("none", "zv", FIRMWARE + "mzv"))
    pieces, _ = simulated(TWO_LAYERS, machine, size=64, methods=("none", "zv", FIRMWARE + "mzv"))
    for a, b in zip(whole.results, pieces.results, strict=True):
        assert a.time == pytest.approx(b.time, abs=1e-4)
        for x, y in zip(a.figures, b.figures, strict=True):
            assert x.total.contour.rms == pytest.approx(y.total.contour.rms, rel=1e-3, abs=0.05)  # um
            assert x.extruding == pytest.approx(y.extruding, abs=2e-3)


def test_what_compensate_predicts_is_what_is_simulated():
    done, _ = simulated(TWO_LAYERS, printer("klipper"), methods=("none", "lpfbs"))
    before, after = (one.figures[0].total.contour.rms for one in done.results)
    told = done.results[1].compensated
    assert before == pytest.approx(told.contour_before.rms, rel=0.03)
    assert after == pytest.approx(told.contour_after.rms, rel=0.03)


def test_a_machine_off_its_model_draws_worse_with_an_exact_inverse():
    machine = printer("klipper")
    done, _ = simulated(TWO_LAYERS, machine, methods=("lpfbs",), mismatches=(0.1,))
    nominal, *others = (figures.total.contour.rms for figures in done.results[0].figures)
    assert [condition.name for condition in done.conditions] == [
        "as modelled", "frequency -10 %", "frequency +10 %", "damping x 1/2", "damping x 2"
    ]  # fmt: skip
    assert min(others) > 1.5 * nominal


def test_another_machine_is_the_machine_that_draws():
    soft = printer("klipper", ModalModel((Mode(20.0, 0.05),)))
    alone, _ = simulated(TWO_LAYERS, soft, methods=("none",))
    other, _ = simulated(TWO_LAYERS, printer("klipper", RIGID), methods=("none",), machine=soft)
    here, there = (done.results[0].figures[0].as_dict(done.features) for done in (other, alone))
    assert here == there


def test_a_machine_whose_places_differ_is_known_where_the_print_is():
    """Two places with the same model are one machine."""
    plain = printer("klipper")
    places = tuple(Place(SOFT, y=y) for y in (0.0, 200.0))
    x, y, z = plain.axes
    varied = replace(plain, axes=(x, replace(y, at=places), z))
    same, _ = simulated(TWO_LAYERS, varied, methods=("none",))
    one, _ = simulated(TWO_LAYERS, plain, methods=("none",))
    here, there = (done.results[0].figures[0].total.contour.rms for done in (same, one))
    assert here == pytest.approx(there, rel=1e-6)


def test_layers_features_and_lines_are_the_files():
    done, seen = simulated(TWO_LAYERS, printer("klipper"), methods=("none", "zv"))
    assert done.features == ("unknown", "wall", "infill") and done.layers == 2
    lines = TWO_LAYERS.splitlines()
    for one in done.results:
        assert set(one.figures[0].by_layer) == {0, 1} and set(one.figures[0].by_feature) == {1, 2}
        printing = seen.row(one.name, "extruding")
        assert all("E1" in lines[k] and "X" in lines[k] for k in set(seen.row(one.name, "line")[printing].tolist()))
        infill = seen.row(one.name, "feature") == 2
        assert (seen.row(one.name, "layer")[infill] == 1).all()
    starts = np.concatenate(seen.starts["zv"])
    assert (np.diff(starts) > 0).all() and len(starts) == done.results[1].compensated.segments
    assert starts[-1] < done.results[1].time


def test_higher_acceleration_prints_faster_and_worse():
    done, _ = simulated(TWO_LAYERS, printer("klipper"), methods=("none",), accelerations=(1000.0, 8000.0))
    slow, fast = done.results
    assert slow.time > fast.time and slow.figures[0].total.contour.rms < fast.figures[0].total.contour.rms
    assert "1000 mm/s^2" in done.text() and "8000 mm/s^2" in done.text()


def test_a_shaper_in_the_firmware_costs_no_time_and_leaves_the_axes_alone():
    machine = printer("klipper")
    done, seen = simulated(TWO_LAYERS, machine, methods=("none", FIRMWARE + "mzv"))
    plain, shaped = done.results
    assert shaped.time == plain.time
    assert shaped.figures[0].total.contour.rms < 0.5 * plain.figures[0].total.contour.rms
    assert len(shaped.made_for) == 2 and "made for x" in done.text()
    assert seen.row(shaped.name, "motion")[-1] == pytest.approx(seen.row("none", "motion")[-1])


def test_a_shaper_for_what_does_not_vibrate_is_refused():
    with pytest.raises(ModelError, match="oscillating mode"):
        simulated(TWO_LAYERS, printer("klipper", RIGID), methods=("mzv",))


def test_without_motors_that_is_said():
    done, _ = simulated(TWO_LAYERS, printer("klipper"), methods=("none",))
    assert "describes no motor" in done.text()


def test_a_plotters_errors_are_those_of_all_its_motion():
    done, _ = simulated(START + ZIGZAG.replace(" E1", ""), printer("klipper"), methods=("none",))
    assert done.results[0].figures[0].extruding == 0.0
    assert f"{done.results[0].figures[0].off.contour.rms:.1f}" in done.text()


def test_a_method_that_is_not_for_the_model_is_left_out_of_a_comparison():
    done, _ = simulated(TWO_LAYERS, printer("klipper", RIGID), methods=("none", "mzv", "lpfbs"))
    assert [one.name for one in done.results] == ["none", "lpfbs"]
    assert any("mzv is left out" in warning for warning in done.warnings)


def test_a_family_is_the_machines_that_its_profile_describes():
    soft = printer("klipper", SOFT)
    x, y, z = soft.axes
    spread = Spread(frequency=(0.9, 1.1))
    of_five = replace(soft, axes=(replace(x, uncertainty=spread), replace(y, uncertainty=spread), z))
    done, _ = simulated(TWO_LAYERS, of_five, methods=("none",), family=True, mismatches=(0.1,))
    names = [condition.name for condition in done.conditions]
    told = dict(zip(names, (figures.drawn for figures in done.results[0].figures), strict=True))
    assert told["family 1/5"] == told["frequency -10 %"]
    assert told["family 3/5"] == told["as modelled"]
    assert told["family 5/5"] == told["frequency +10 %"]
    exact = replace(soft, axes=(replace(x, uncertainty=Spread()), replace(y, uncertainty=Spread()), z))
    assert len(simulated(TWO_LAYERS, exact, methods=("none",), family=True)[0].conditions) == 1
