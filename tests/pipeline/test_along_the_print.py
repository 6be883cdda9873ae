"""Laws of a print whose plants are uncertain, or change along it."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from print_cases import START, compensated, end_of, printer, prints, read

from fbfcli.gcode.scan import chunks
from fbfcli.motion import planner
from fbfcli.motion.moves import E
from fbfcli.pipeline import Settings, compensate
from fbfcli.pipeline.designs import EVERY, Designs
from fbfcli.plant.model import modes
from fbfcli.printer import FIRMWARES, ModalModel, Mode, Place, Printer, Spread
from fbfcli.verify.tally import Stretches, Tally

POSITION_MM = 2e-5  # two words rounded to five decimals
each_firmware = pytest.mark.parametrize("firmware", FIRMWARES)
few = settings(max_examples=8)
ONLY_E = slice(E, E + 1)
ROBUST, CONTOUR, LPFBS = (Settings(method=name, patch_times=False) for name in ("robust", "contour", "lpfbs"))
SQUARES = START + "".join(
    f"G1 X{x} Y{y} E1.5 F9000\n" for _ in range(12) for x, y in ((140, 100), (140, 140), (100, 140), (100, 100)))


def one(f: float) -> ModalModel:
    return ModalModel((Mode(f, 0.05),))


def along(firmware: str = "klipper", **ends: tuple[float, float]) -> Printer:
    """Y falls from 40 to 32 Hz between the two values of the coordinate named."""
    base = printer(firmware)
    (name, values), = ends.items()
    at = tuple(Place(one(f), **{name: value}) for f, value in zip((40.0, 32.0), values, strict=True))
    x, y, z = base.axes
    return replace(base, axes=(replace(x, model=one(45.0)), replace(y, model=one(40.0), at=at), z))


def executed(text: str, machine: Printer, how: Settings) -> list[Stretches]:
    """What the firmware makes of the written text."""
    told: list[Stretches] = []
    compensate(chunks(io.BytesIO(text.encode())), machine, how, lambda written: None, watch=told.append)
    return told


@each_firmware
@few
@given(st.data(), st.sampled_from((ROBUST, CONTOUR)))
def test_the_file_ends_where_it_did_with_as_much_pushed(firmware, data, how):
    written = compensated(data.draw(prints(firmware)), printer(firmware), how)
    before, after = read(written.source, written.printer), written.block()
    np.testing.assert_allclose(end_of(after.moves), end_of(before.moves), atol=POSITION_MM)
    np.testing.assert_allclose(after.e_logical[-1], before.e_logical[-1], atol=POSITION_MM)


@few
@given(st.data())
def test_each_retraction_and_pause_finds_the_filament_where_it_was(data):
    """E at every line that moves it alone is the file's: only what is pushed on the way between is shifted."""
    kinds = ("print", "print", "travel", "retract", "wait")
    written = compensated(data.draw(prints("klipper", kinds)), printer("klipper"), CONTOUR)
    before, after = (block.moves for block in (read(written.source, written.printer), written.block()))
    alone = [m.start[(m.delta[:, :3] == 0.0).all(axis=1) & (m.delta[:, E] != 0.0), E] for m in (before, after)]
    np.testing.assert_allclose(alone[1], alone[0], atol=1e-4)


def test_filament_follows_the_nozzle_only_where_it_is_asked_to():
    plan, nozzle = (replace(CONTOUR, with_nozzle=asked) for asked in (False, True))
    prints_ = [executed(SQUARES, printer("klipper"), how) for how in (plan, nozzle, CONTOUR)]
    at_plan, at_nozzle, by_default = (np.concatenate([part.positions(ONLY_E) for part in each]) for each in prints_)
    assert 1e-4 < np.abs(at_plan - at_nozzle).max() < 0.1
    np.testing.assert_array_equal(at_nozzle, by_default)


@pytest.mark.parametrize("how", (LPFBS, CONTOUR), ids=lambda how: how.method)
def test_a_stretch_in_parts_is_the_stretch_in_one_piece(monkeypatch, how):
    """Compensated with models that change on the way, in parts of 0.4 s."""
    machine = along(x=(100.0, 140.0))
    whole = compensated(SQUARES, machine, how)
    monkeypatch.setattr(planner, "PART_S", 0.4)
    parts = compensated(SQUARES, machine, how)
    assert parts.done.time == pytest.approx(whole.done.time, abs=2e-3)
    assert parts.done.summary.contour_after.rms == pytest.approx(whole.done.summary.contour_after.rms, rel=0.3)


@pytest.mark.parametrize("coordinate", ["x", "z", "mass"])
@pytest.mark.parametrize("how", (LPFBS, CONTOUR), ids=lambda how: how.method)
def test_following_the_models_beats_any_one_of_them(coordinate, how):
    """On the machine whose plant changes, as the summary predicts it."""
    ends = {"x": (100.0, 140.0), "z": (0.3, 3.9), "mass": (0.0, 1.1 * 12 * 6.0 * 2.98e-6)}[coordinate]
    machine = along(**{coordinate: ends})
    text = SQUARES
    if coordinate == "z":
        squares = SQUARES.removeprefix(START).splitlines(keepends=True)
        layers = ["".join(squares[4 * k : 4 * k + 4]) for k in range(12)]
        text = START + "".join(f"G1 Z{0.3 + 0.3 * k:.1f} F900\n{layer}" for k, layer in enumerate(layers))
    followed = compensated(text, machine, how).done.summary.contour_after.rms
    x, y, z = machine.axes
    told = executed(text, replace(machine, axes=(x, replace(y, at=()), z)), how)
    assert followed < 0.7 * error_on(told, machine)


def error_on(told: list[Stretches], machine: Printer) -> float:
    """What a file written for another machine does on this one [um]."""
    designs = Designs(machine, "none", Settings())
    tally = Tally(designs.b_a)
    for part in told:
        tally.add(replace(part, place=designs.places(part.positions(slice(4)))))
    return tally.after.figures()["rms"]


def test_places_are_told_apart_in_small_steps_and_one_model_is_one_place():
    fixed = Designs(printer("klipper"), "lpfbs", Settings())
    x = np.column_stack([np.linspace(100, 140, 40 * EVERY), *np.zeros((3, 40 * EVERY))])
    assert not fixed.places(x).any()
    designs = Designs(along(x=(100.0, 140.0)), "lpfbs", Settings())
    places = designs.places(x)
    assert len(places) == len(x)
    f = [modes(designs.plants(place)[1])[0].frequency for place in dict.fromkeys(places.tolist())]
    assert f[0] == pytest.approx(40.0)
    assert f[-1] == pytest.approx(32.0, rel=0.01)
    assert np.abs(np.diff(f) / f[:-1]).max() < 0.01
    assert modes(designs.plants(0)[1])[0].frequency == pytest.approx(40.0), "place 0 is the nominal model"


def test_a_method_for_families_knows_them():
    base = printer("klipper")
    spread = replace(base, axes=(*(replace(a, uncertainty=Spread((0.8, 1.2))) for a in base.axes[:2]), base.axes[2]))
    assumed, told = (executed(SQUARES, machine, CONTOUR)[0].command for machine in (base, spread))
    asked = executed(SQUARES, base, replace(CONTOUR, spread=0.2))[0].command
    np.testing.assert_array_equal(told, asked)
    both = min(len(assumed), len(told))
    assert np.abs(assumed[:both] - told[:both]).max() > 1e-3
