"""Two axes that move each other."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from execution_cases import RIGID, execution, mode, wandering
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.cli.lookup import bundled
from fbfcli.errors import ModelError, ProfileError
from fbfcli.pipeline import Settings, compensate
from fbfcli.plant.coupling import coupling
from fbfcli.printer import ModalModel, Mode, Printer, TransferFunction
from fbfcli.printer_toml import parse_printer
from fbfcli.verify.passages import Passages
from fbfcli.verify.simulate import Nozzle

DT = 1e-3
PROFILE = Path(__file__).parents[2] / "configs" / "synthetic_corexy.toml"
ROCKS = ModalModel((Mode(32.0, 0.05, 0.1), Mode(45.0, 0.05, -0.1)))
SEEDS = st.integers(0, 2**32 - 1)


def coupled(x=None, y=None) -> Printer:
    printer = bundled()["synthetic_corexy"]
    axes = tuple(replace(axis, coupling=c) for axis, c in zip(printer.axes, (x, y, None), strict=True))
    return replace(printer, axes=axes)


def nozzle(plants, filters, command: np.ndarray, begin=(0,), rest=(0,)) -> np.ndarray:
    return Nozzle(plants, filters).follow(command, np.array(begin), np.array(rest))


@settings(max_examples=25)
@given(SEEDS)
def test_what_is_added_is_the_filtered_command_of_the_other_axis(seed):
    command = wandering(seed, 600, []).desired
    filters = coupling(coupled(ROCKS, None), DT)
    alone, together = (nozzle(mode(40.0, 0.1), each, command) for each in ((None, None), filters))
    only_y = command * [0.0, 1.0]
    added = nozzle(RIGID, filters, only_y)[:, 0]
    np.testing.assert_allclose(together[:, 0] - alone[:, 0], added, atol=1e-9)
    np.testing.assert_array_equal(together[:, 1], alone[:, 1])
    assert np.abs(added).max() > 1e-6


@settings(max_examples=25)
@given(SEEDS)
def test_superposition(seed):
    a, b = (wandering(seed + i, 600, []).desired - 100.0 for i in range(2))
    a, b = a - a[0], b - b[0]
    filters = coupling(coupled(ROCKS, ROCKS), DT)
    y = [nozzle(mode(40.0, 0.1), filters, command) for command in (a, b, 2 * a - 3 * b)]
    np.testing.assert_allclose(y[2], 2 * y[0] - 3 * y[1], atol=1e-8)


@settings(max_examples=25)
@given(SEEDS, st.lists(st.integers(1, 599), max_size=4))
def test_no_gain_changes_nothing_and_pieces_are_the_whole(seed, cuts):
    command = wandering(seed, 600, []).desired
    none = coupling(coupled(ModalModel((Mode(32.0, 0.05, 0.1), Mode(32.0, 0.05, -0.1))), None), DT)
    np.testing.assert_allclose(nozzle(RIGID, none, command), nozzle(RIGID, (None, None), command), atol=1e-12)
    filters = coupling(coupled(ROCKS, ROCKS), DT)
    machine, parts, at = Nozzle(mode(40.0, 0.1), filters), [], 0
    for end in [*sorted(set(cuts)), 600]:
        begin = np.array([0] if at == 0 else [], dtype=int)
        parts.append(machine.follow(command[at:end], begin, np.zeros(len(begin), int)))
        at = end
    np.testing.assert_allclose(np.vstack(parts), nozzle(mode(40.0, 0.1), filters, command), atol=1e-9)


def test_at_rest_nothing_moves():
    """Neither before it has begun, nor where it has come to rest, nor by moves between stretches."""
    filters = coupling(coupled(ROCKS, ROCKS), DT)
    still = np.full((3000, 2), 70.0)
    np.testing.assert_allclose(nozzle(RIGID, filters, still), 70.0, atol=1e-12)
    step = np.vstack([still[:10], still + np.array([5.0, 20.0])])
    np.testing.assert_allclose(nozzle(RIGID, filters, step)[-1], [75.0, 90.0], atol=1e-6)
    np.testing.assert_allclose(nozzle(RIGID, filters, step, (0, 10), (0, 0)), step, atol=1e-12)


def test_a_passage_holds_it():
    whole = wandering(5, 600, [])
    plain, moved = (Passages(RIGID, each) for each in ((None, None), coupling(coupled(ROCKS, None), DT)))
    assert plain.add(whole).tracking.max() < 1e-9 < moved.add(whole).tracking.max()
    assert execution(np.zeros((0, 2)), begin=()).dt == DT


def profile(text: str) -> Printer:
    return parse_printer(PROFILE.read_text() + text, "my.toml")


MODES = "modes = [{ frequency = 32, damping = 0.05, gain = 0.1 }, { frequency = 45, damping = 0.05, gain = -0.1 }]"


def test_a_profile_says_it():
    printer = profile(
        f"\n[axis.x.coupling]\n{MODES}\n[axis.y.coupling]\nb = [0, 0.1, -0.1]\na = [1.0, -0.5]\ndt = 0.001"
    )
    assert printer.axes[0].coupling == ROCKS
    assert printer.axes[1].coupling == TransferFunction((0.0, 0.1, -0.1), (1.0, -0.5), 0.001)
    assert bundled()["synthetic_corexy"].axes[0].coupling is None


@pytest.mark.parametrize(
    "text, why",
    [
        ("[axis.x.coupling]\nmodes = [{ frequency = 32, damping = 0.05 }]", "the gains sum to 1, not 0"),
        ("[axis.x.coupling]\nb = [0.1]\na = [1.0]\ndt = 0.001", "sums to 0.1, not 0"),
        ("[axis.x.coupling]\nimpulse_response = 'x.csv'", "unknown key"),
        ("[axis.z.coupling]\nb = [0.1, -0.1]\na = [1.0]\ndt = 0.001", "unknown key"),
        ("[axis.x.coupling]", "is missing"),
    ],
)
def test_bad_couplings_are_refused_in_one_line(text, why):
    with pytest.raises(ProfileError, match=why) as refused:
        profile("\n" + text)
    assert "coupling" in str(refused.value) and "\n" not in str(refused.value)


def test_a_coupling_that_does_not_decay_is_refused():
    printer = coupled(TransferFunction((0.1, -0.1), (1.0, -1.1), DT), None)
    with pytest.raises(ModelError, match="does not decay"):
        coupling(printer, DT)


def test_the_summary_says_that_it_is_simulated_and_not_compensated():
    text = b"G28\nG1 X10 Y10 F6000\nG1 X20 Y10 E1\nG1 X20 Y20 E2\n"

    def summary(printer: Printer):
        return compensate([text], printer, Settings(method="lpfbs"), lambda written: None).summary

    told, plain = summary(coupled(ROCKS, ROCKS)), summary(coupled())
    assert any("not compensated" in warning for warning in told.warnings)
    assert not any("coupling" in warning for warning in plain.warnings)
    assert told.contour_after.max > 2 * plain.contour_after.max
