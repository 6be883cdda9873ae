"""Lines become moves: chunks do not matter, displacements add up, modes mean what each firmware means."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reading_cases import block_of, blocks_of, files, firmwares, joined, moves_of, printer, whole
from slow_reader import SlowReader

from fbfcli.errors import GcodeError
from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.interpret import initial_state
from fbfcli.motion.moves import E

PER_LINE = ("kind", "wait", "known", "offset", "xy_relative", "e_relative", "inch", "e_logical", "feed", "speed_factor",
            "motion_mode", "state")  # fmt: skip
PER_MOVE = ("moves.start", "moves.delta", "moves.speed", "moves.stop", "moves.state", "moves.line")


def readable(text, firmware):
    """The text as one block, and the state after it; None where a line of it is impossible."""
    try:
        return whole(text, firmware)
    except GcodeError as error:
        assert any(word in error.why for word in ("arc", "curve", "G5", "absurd", "above zero"))
        return None


@given(files, firmwares, st.integers(1, 200))
def test_chunks_of_any_size_are_the_whole(text, firmware, size):
    read = readable(text, firmware)
    if not text or read is None:
        return
    block, state = read
    parts, last = blocks_of(text, firmware, size)
    for name in PER_LINE + PER_MOVE:
        np.testing.assert_allclose(joined(parts, name), joined([block], name), rtol=1e-12, atol=1e-6)
    assert last.limits == state.limits
    assert sorted(w for part in parts for w in part.warnings) == sorted(block.warnings)


@given(files, firmwares)
def test_displacements_add_up(text, firmware):
    """A move starts where the last one ended, unless the machine moved by itself or a position was declared."""
    read = readable(text, firmware)
    if read is None:
        return
    block, moves = read[0], read[0].moves
    gap = moves.start[1:] - (moves.start + moves.delta)[:-1]
    alone = np.isin(block.kind, (Kind.BARRIER, Kind.MODE))
    between = np.cumsum(alone)[moves.line]
    quiet = between[1:] == between[:-1]
    assert np.all(np.abs(gap[quiet]) <= 1e-9 * (1 + np.abs(moves.start[1:][quiet]).max(initial=0)))
    assert np.all(np.abs(gap[:, E]) < 1e-6)  # E is never reset


@given(files, firmwares)
def test_feed_rates_are_positive_and_lines_in_order(text, firmware):
    read = readable(text, firmware)
    if read is None:
        return
    moves = read[0].moves
    assert np.all(moves.speed > 0)
    assert np.all(np.diff(moves.line) >= 0)
    assert np.isfinite(moves.start).all() and np.isfinite(moves.delta).all()
    assert len(moves) == 0 or moves.stop[0]


@pytest.mark.parametrize("firmware", ["klipper", "marlin", "reprapfirmware"])
def test_corpus_agrees_with_a_plain_reader(corpus_file, firmware):
    """Displacement of every line, total E, end position, speeds and limits; no line of the corpus is misread."""
    text = corpus_file.read_bytes()
    if firmware == "klipper" and b"\nG20" in text:
        with pytest.raises(GcodeError, match="inches"):
            blocks_of(text, firmware)
        return
    blocks, state = blocks_of(text, firmware, 30_000)
    slow = SlowReader(firmware)
    slow.read(text.decode("latin-1"))
    line, delta, speed = (joined(blocks, f"moves.{name}") for name in ("line", "delta", "speed"))
    steps = np.array(slow.steps).reshape(-1, 5)
    moved, first = np.unique(line, return_index=True)
    assert moved.tolist() == steps[:, 0].tolist()
    per_line = np.add.reduceat(delta, first, axis=0) if len(first) else delta
    np.testing.assert_allclose(per_line, steps[:, 1:], atol=1e-9)
    np.testing.assert_allclose(speed[first], slow.feeds, rtol=1e-12)
    np.testing.assert_allclose(delta.sum(axis=0), [slow.moved[k] for k in "XYZE"], atol=1e-6)
    np.testing.assert_allclose(state.logical, [slow.at[k] for k in "XYZE"], atol=1e-6)
    limits = state.limits[state.in_force]
    for name, value in slow.limits.items():
        axis = "XYZE".find(name[-1])
        assert (limits.jerk[axis] if name.startswith("jerk") else getattr(limits, name)) == value


@given(st.text("GGXYZEFIJRPMNT0123456789.+-*;() \t\r\n{}=_é", max_size=80), firmwares)
def test_anything_is_read_or_refused(text, firmware):
    try:
        block, _ = whole(text, firmware)
    except GcodeError as error:
        assert error.line is not None
        assert error.remedy
        return
    assert len(block.kind) == text.count("\n") + (text[-1:] not in ("", "\n"))
    assert np.isfinite(block.moves.delta).all()


def test_relative_and_absolute():
    moves = moves_of("G90\nG1 X10 Y5 F600\nG91\nG1 X1\nG1 Y-2 E.5\nG90\nG1 X0 E3")
    assert moves.delta.tolist() == [[10, 5, 0, 0], [1, 0, 0, 0], [0, -2, 0, 0.5], [-11, 0, 0, 2.5]]
    assert moves.start[-1].tolist() == [11, 3, 0, 0.5]
    assert moves.speed.tolist() == [10.0] * 4


@pytest.mark.parametrize(
    ("firmware", "commands", "relative"),
    [
        ("marlin", "G91", True), ("klipper", "G91", True), ("reprapfirmware", "G91", False),
        ("marlin", "M83|G90", False), ("klipper", "M83|G90", True), ("reprapfirmware", "M83|G90", True),
        ("marlin", "G91|M82", False), ("klipper", "G91|M82", True), ("reprapfirmware", "G91|M82", False),
    ],
)  # fmt: skip
def test_g90_and_g91_move_e_or_not(firmware, commands, relative):
    assert block_of(commands.replace("|", "\n"), firmware).e_relative[-1] == relative


def test_g92_moves_coordinates_not_the_machine():
    block = block_of("G1 X10 Y10 E5 F600\nG92 X0 E0\nG1 X5 E1\nG92 E0\nG1 X6 E2")
    assert block.moves.start[:, 0].tolist() == [0, 10, 15]
    assert block.moves.start[:, E].tolist() == [0, 5, 6]
    assert block.moves.delta[:, E].tolist() == [5, 1, 2]
    assert block.offset[:, 0].tolist() == [0, 10, 10, 10, 10]
    assert block.e_logical.tolist() == [5, 0, 1, 0, 2]


def test_bare_g92_zeroes_klipper_only():
    assert blocks_of("G1 X5 E2\nG92", "klipper")[1].logical == (0, 0, 0, 0)
    assert blocks_of("G1 X5 E2\nG92", "marlin")[1].logical == (5, 0, 0, 2)


def test_inches_are_converted_once():
    block = block_of("G20\nG1 X1 Y.5 F60\nG21\nG1 X0 F1200\nG1 X1")
    assert block.moves.delta[:, 0].tolist() == [25.4, -25.4, 1.0]
    assert block.moves.speed.tolist() == [25.4, 20.0, 20.0]
    assert block.feed[1] == 60.0
    moves = moves_of("G20\nG1 X1 F60\nG21\nG1 X0")  # F keeps the unit it was written in
    assert moves.speed.tolist() == [25.4, 25.4]


def test_speed_factor():
    assert moves_of("M220 S50\nG1 X1").speed.tolist() == [12.5]
    assert moves_of("G1 X1 F600\nM220 S50\nG1 X2\nM220 S100\nG1 X3").speed.tolist() == [10, 5, 10]


def test_moves_before_any_feed_go_at_25_and_say_so_once():
    blocks, _ = blocks_of("G1 X1\nG1 X2\nG1 X3 F600\n", size=8)
    assert joined(blocks, "moves.speed").tolist() == [25, 25, 10]
    assert sum(len(b.warnings) for b in blocks) == 1


def test_modal_lines_without_g():
    moves = moves_of("G1 F600\nX5\nY5 F1200\nG2 X6 Y6 I1\nX7 Y7 J1\nG0\nX0")
    assert moves.line[[0, 1, -1]].tolist() == [1, 2, 6]
    assert set(moves.line.tolist()) == {1, 2, 3, 4, 6}


def test_position_is_unknown_until_commanded():
    text = "G1 X1 Y1 F600\nT0\nG1 X2\nG1 Y3\nG28\nG1 Z5\nG1 X0 Y0\nG91\nG1 X1\nPAUSE\nG1 X1 Y1\nG90\nG92 X0 Y0\n"
    expected = [1, 0, 0, 1, 0, 0, 1, 1, 1, 0, 0, 0, 1]
    assert block_of(text).known.astype(int).tolist() == expected
    blocks, _ = blocks_of(text, size=5)
    assert joined(blocks, "known").astype(int).tolist() == expected


def test_rests():
    text = "G1 X1 F600\nG1 X2\nG4 P500\nG1 X3\nM104 S200\nG1 X4\nG10\nG11\nG1 X5\nM400\n; end\nG1 X6"
    for size in (1, 1000):
        blocks, _ = blocks_of(text, size=size)
        assert joined(blocks, "moves.stop").tolist() == [True, False, True, False, True, True]
        assert joined(blocks, "wait").sum() == 0.5


def test_limits_in_force():
    moves = moves_of("G1 X1 F60\nM204 P500\nG1 X2\nM204 P700\nG1 X3\nM204 P500\nG1 X4")
    assert moves.limit("acceleration").tolist() == [3000, 500, 700, 500]
    assert len(moves.limits) == 3


def test_several_commands_on_a_line():
    block = block_of("G17 G91 G21\nN5 G1 X1 Y2 G90 F60\nG1 X0", "reprapfirmware")
    assert block.kind.tolist() == [Kind.MODE, Kind.MOTION, Kind.MOTION]
    assert block.moves.delta[:, 0].tolist() == [1, -1]
    assert not block.warnings
    assert "only the first" in block_of("G17 G90 G21").warnings[0]


def test_placeholders_pass_and_lose_the_position():
    block = block_of("G1 X1 Y1 F60\nG1 X{move.axes[0].max}\nG1 Y5", "reprapfirmware")
    assert block.kind[1] == Kind.BARRIER
    assert block.known.tolist() == [True, False, False]
    assert block.warnings


def test_endstop_moves_are_barriers():
    assert block_of("G1 H1 X-200 F600", "reprapfirmware").kind.tolist() == [Kind.BARRIER]


def test_home_is_inside_the_travel():
    state = initial_state(printer())
    assert state.home == (0, 0, 0)
    assert state.known == (False, False)


def test_inches_are_refused_for_klipper_with_place_and_remedy():
    with pytest.raises(GcodeError) as caught:
        blocks_of("G90\nG20\n", "klipper")
    assert caught.value.line == 2
    assert "millimetres" in caught.value.remedy
