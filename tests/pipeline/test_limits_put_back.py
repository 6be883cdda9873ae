"""Limits of the firmware in a compensated file: raised for segments only, put back, and kept by the command."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from print_cases import START, bare, compensated, end_of, printer, prints, random_print, read

from fbfcli.gcode.dialects import Kind
from fbfcli.motion.timing import executed
from fbfcli.pipeline import Settings
from fbfcli.printer import FIRMWARES

POSITION_MM = 2e-5  # two words rounded to five decimals
each_firmware = pytest.mark.parametrize("firmware", FIRMWARES)
few = settings(max_examples=25)
LPFBS, ZV = (Settings(method=name, patch_times=False) for name in ("lpfbs", "zv"))


@each_firmware
@few
@given(st.data(), st.sampled_from((LPFBS, ZV)))
def test_limits_at_every_barrier_and_at_the_end_are_the_files_own(firmware, data, how):
    written = compensated(data.draw(prints(firmware)), printer(firmware), how)
    sets = []
    for text in (written.source, written.text):
        block = read(text, written.printer)
        barriers = np.flatnonzero(block.kind == Kind.BARRIER)
        at = [i for i in barriers if not re.match(rb"M593|M493|SET_INPUT", block.lines.raw(i))]
        sets.append([block.moves.limits[block.state[i]] for i in [*at, -1]])
    assert sets[0] == sets[1]


@each_firmware
@few
@given(st.data())
def test_no_limit_line_acts_while_limits_are_raised(firmware, data):
    """What the file says of limits inside a run waits as a comment: segments are under raised ones."""
    kinds = ("print", "print", "travel", "limits", "limits", "fan", "retract", "wait")
    written = compensated(data.draw(prints(firmware, kinds)), printer(firmware), LPFBS)
    moves = written.block().moves
    flat = (moves.delta[:, :2] != 0.0).any(axis=1) & (moves.line > written.lines.index(b"G1 X100 Y100 F6000"))
    verbatim = {bare(line) for line in written.source.splitlines()}
    segments = np.flatnonzero(flat & [written.lines[i] not in verbatim for i in moves.line])
    acceleration = moves.limit("acceleration")[segments]
    assert not len(acceleration) or acceleration.min() >= 1e6


@pytest.mark.parametrize("firmware", ("klipper", "reprapfirmware"))
def test_a_slowed_stretch_takes_the_same_path(firmware):
    square = "G1 X140 Y100 E1 F9000\nG1 X140 Y140 E1\nG1 X100 Y100 E1\n"
    text = START + square + "G4 P10\nG1 X101 Y101 F600\n"
    fast, slow = (compensated(text, printer(firmware, command_velocity=v), LPFBS) for v in (600.0, 150.5))
    assert fast.done.summary.slowed == 0 and slow.done.summary.slowed == 1 and slow.done.summary.slowest > 1.0
    assert slow.done.time > fast.done.time
    corners = np.array([[100, 100], [140, 100], [140, 140], [100, 100]], float)
    moves = slow.block().moves
    for point in (moves.start + moves.delta)[2:-20, :2]:
        assert min(_to_segment(point, a, b) for a, b in pairwise(corners)) < 0.4
    np.testing.assert_allclose(end_of(moves), end_of(fast.block().moves), atol=POSITION_MM)


def _to_segment(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    s = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return float(np.hypot(*(p - a - s * (b - a))))


def hardest_joint(text: bytes, machine) -> float:
    """Highest speed at which a move of Z or E alone joins one of X and Y [mm/s]."""
    moves = read(text, machine).moves
    timing = executed(moves, machine.firmware)
    flat = (moves.delta[:, :2] != 0.0).any(axis=1)
    begins, ends = ~flat[1:] & flat[:-1], ~flat[:-1] & flat[1:]
    return float(max(timing.v_start[1:][begins].max(initial=0.0), timing.v_end[:-1][ends].max(initial=0.0)))


@pytest.mark.parametrize("how", (LPFBS, ZV), ids=lambda how: how.method)
@each_firmware
def test_z_and_e_are_not_jerked_by_raised_limits(firmware, how):
    """Limits stay raised beside a lift or a retraction; the segments there are slow."""
    machine, before, after = printer(firmware), 0.0, 0.0
    for seed in range(20):
        text = random_print(seed, 15, firmware, ("print", "print", "lift", "retract"))
        before = max(before, hardest_joint(text.encode(), machine))
        after = max(after, hardest_joint(compensated(text, machine, how).text, machine))
    assert after <= 1.05 * before


@each_firmware
@few
@given(st.data())
def test_a_steep_move_of_x_and_y_has_the_files_own_limits(firmware, data):
    """It stays as it was written: with limits raised it would take corners at full speed."""
    lines = ["G1 X120 Y110 E1 F6000"]
    for _ in range(data.draw(st.integers(1, 6))):
        x, y = data.draw(st.integers(60, 140)), data.draw(st.integers(60, 140))
        z = data.draw(st.sampled_from((1, 31)))
        lines.append(
            data.draw(st.sampled_from((f"G1 X{x} Y{y} E1", f"G1 X{x} Y{y} Z{z}", "G1 E-1 F1800", "M204 S700")))
        )
    written = compensated(START + "\n".join(lines) + "\n", printer(firmware), LPFBS)
    found = {}
    for name, text in (("source", written.source), ("text", written.text)):
        moves = read(text, written.printer).moves
        steep = np.flatnonzero((np.abs(moves.delta[:, 2]) > 10.0) & (moves.delta[:, :2] != 0.0).any(axis=1))
        found[name] = [moves.limits[i] for i in moves.state[steep]]
    assert found["text"] == found["source"]
