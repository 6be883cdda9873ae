"""Laws of a whole compensated file: nothing lost, nothing moved, limits put back, however the text arrives."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from print_cases import (
    RIGID,
    START,
    bare,
    compensated,
    end_of,
    in_order,
    print_time,
    printer,
    prints,
    random_print,
    read,
)

from fbfcli.errors import GcodeError
from fbfcli.gcode.dialects import Kind
from fbfcli.motion import planner
from fbfcli.motion.sample import sample
from fbfcli.motion.timing import executed
from fbfcli.pipeline import Settings
from fbfcli.printer import FIRMWARES

POSITION_MM = 2e-5  # two words rounded to five decimals
FAST = 1000.0  # segments per second: tolerances bind, not the firmware
# half a millisecond at 200 mm/s, and what Marlin's shortest segment leaves over
SAME_PATH_MM = {"klipper": 0.1, "reprapfirmware": 0.1, "marlin": 0.3}
each_firmware = pytest.mark.parametrize("firmware", FIRMWARES)
few = settings(max_examples=25)
LPFBS, ZV, NONE = (Settings(method=name, patch_times=False) for name in ("lpfbs", "zv", "none"))
DRAWN = ("print", "print", "arc", "travel", "wipe")
STREAMED = (
    "print",
    "print",
    "print",
    "travel",
    "fan",
    "limits",
    "reset",
    "feed",
    "wipe",
    "spiral",
    "absolute_e",
    "relative_e",
)


def kept_lines(text: bytes, machine) -> list[bytes]:
    """Every line of a file that is no motion; of G92 E only that it is one: its number follows the machine."""
    kinds = read(text, machine).kind
    lines = [bare(line) for line, kind in zip(text.splitlines(), kinds, strict=True) if kind != Kind.MOTION]
    return [re.sub(rb"^G92 E.*", b"G92 E", line) for line in lines]


def followed(written, dt: float = 5e-3) -> np.ndarray:
    """Where the firmware has the tool every `dt` seconds of a written file, shape (k, 4)."""
    moves = written.block().moves
    timing = executed(moves, written.printer.firmware)
    t0 = np.cumsum(timing.duration) - timing.duration
    return sample(moves.start, moves.delta, moves.distance, timing, t0, int(written.done.time / dt), dt)[0]


def same_path(written, other, tolerance: float) -> None:
    a, b = followed(written), followed(other)
    n = min(len(a), len(b))
    assert abs(len(a) - len(b)) <= 1
    np.testing.assert_allclose(b[:n], a[:n], rtol=0, atol=tolerance)


@each_firmware
@few
@given(st.data())
def test_every_line_without_motion_is_written_once_and_in_its_order(firmware, data):
    written = compensated(data.draw(prints(firmware)), printer(firmware), ZV)
    wanted = kept_lines(written.source, written.printer)
    found = [re.sub(rb"^G92 E.*", b"G92 E", bare(line)) for line in written.lines]
    assert in_order(wanted, found) is None
    for line in set(wanted) - {b""}:
        extra = line.startswith(
            (b"M20", b"M566", b"SET_VELOCITY_LIMIT")
        )  # these are also put in front of and after runs
        assert extra or found.count(line) == wanted.count(line)


@each_firmware
@few
@given(st.data(), st.sampled_from((LPFBS, ZV, NONE)))
def test_the_file_ends_where_it_did_with_as_much_pushed(firmware, data, how):
    written = compensated(data.draw(prints(firmware)), printer(firmware), how)
    before, after = read(written.source, written.printer), written.block()
    np.testing.assert_allclose(end_of(after.moves), end_of(before.moves), atol=POSITION_MM)
    np.testing.assert_allclose(after.e_logical[-1], before.e_logical[-1], atol=POSITION_MM)
    np.testing.assert_allclose(after.offset[-1], before.offset[-1], atol=POSITION_MM)


@each_firmware
@few
@given(st.data(), st.integers(1, 400))
def test_the_output_does_not_depend_on_how_the_text_arrives(firmware, data, size):
    text = data.draw(prints(firmware, STREAMED))
    whole = compensated(text, printer(firmware, rate=FAST), LPFBS)
    pieces = compensated(text, printer(firmware, rate=FAST), LPFBS, size=size)
    assert kept_lines(whole.text, whole.printer) == kept_lines(pieces.text, whole.printer)
    assert pieces.done.time == pytest.approx(whole.done.time, abs=5e-3)
    same_path(whole, pieces, SAME_PATH_MM[firmware])


@each_firmware
@pytest.mark.parametrize("how", (LPFBS, ZV, NONE), ids=lambda how: how.method)
def test_a_stretch_in_parts_is_the_stretch_in_one_piece(monkeypatch, firmware, how):
    text = random_print(5, 60, firmware, ("print", "wipe", "fan"))
    whole = compensated(text, printer(firmware, rate=FAST), how)
    monkeypatch.setattr(planner, "PART_S", 0.4)
    parts = compensated(text, printer(firmware, rate=FAST), how)
    assert kept_lines(whole.text, whole.printer) == kept_lines(parts.text, whole.printer)
    assert parts.done.time == pytest.approx(whole.done.time, abs=2e-3)
    same_path(whole, parts, SAME_PATH_MM[firmware])
    for name in ("follow_error", "contour_before", "contour_after"):
        a, b = (getattr(one.done.summary, name).rms for one in (whole, parts))
        rel, within = (0.1, 0.5) if firmware == "klipper" else (0.5, 1.5)  # few segments: fitted part by part
        assert b == pytest.approx(a, rel=rel, abs=within)


@each_firmware
@few
@given(st.data(), st.sampled_from((LPFBS, ZV, NONE)))
def test_the_time_told_is_the_time_the_firmware_takes(firmware, data, how):
    """Within 2 %: a planner does not halt between a stretch and a lift or a retraction."""
    kinds = ("print", "print", "travel", "fan", "retract", "limits", "lift", "wait")
    written = compensated(data.draw(prints(firmware, kinds)), printer(firmware), how)
    summary, machine = written.done.summary, written.printer
    assert summary.time == pytest.approx(print_time(written.text, machine), rel=0.02, abs=2e-3)
    assert summary.time_as_sliced == pytest.approx(print_time(written.source, machine), rel=1e-9)


@each_firmware
@few
@given(st.data())
def test_written_segments_keep_the_clock(firmware, data):
    """Travel and print moves, E within its limits: 50 ppm, or 50 us of a short print."""
    kinds = ("travel", "fan", "print")
    summary = compensated(data.draw(prints(firmware, kinds)), printer(firmware, rate=FAST), LPFBS).done.summary
    compensated_s = summary.segments / max(summary.segments_per_second, 1e-9)
    early = 3000.0 * summary.stretches if firmware == "reprapfirmware" else 0.0  # the slow last segment of each
    assert abs(summary.clock_drift_ppm) * compensated_s < 50.0 + 50.0 * compensated_s + early
    # Marlin drops short segments, RepRapFirmware speeds slow ones up: they are made longer, and follow less well
    assert summary.follow_error.max < {"klipper": 40.0, "marlin": 500.0, "reprapfirmware": 200.0}[firmware]


@each_firmware
@few
@given(st.data())
def test_a_rigid_machine_uncompensated_has_no_error_of_its_own(firmware, data):
    machine = printer(firmware, RIGID)
    summary = compensated(data.draw(prints(firmware, DRAWN)), machine, NONE).done.summary
    assert summary.contour_before.max < 1e-3
    assert summary.contour_after.max <= summary.follow_error.max + summary.chord_error.max + 1e-6


def told_anew(moves, xy_relative: bool, e_relative: bool) -> str:
    """Moves as lines in other modes; G91 moves E too in Marlin and Klipper, so it comes with M83."""
    lines, e = [START + ("G91" if xy_relative else "G90"), "M83" if e_relative else "M82\nG92 E0"], 0.0
    for start, delta, speed in zip(moves.start[2:], moves.delta[2:], moves.speed[2:], strict=True):
        before, after = np.round(start[:2], 3), np.round(start[:2] + delta[:2], 3)
        x, y = after - before if xy_relative else after
        pushed = round(delta[3], 5)
        e = round(e + pushed, 5)
        lines.append(f"G1 X{x:.3f} Y{y:.3f} E{pushed if e_relative else e:.5f} F{60 * speed:.3f}")
    return "\n".join(lines) + "\n"


@each_firmware
@few
@given(st.data())
def test_relative_and_absolute_words_lead_along_the_same_path(firmware, data):
    """The same motion asked for in G90 and G91, M82 and M83."""
    machine = printer(firmware, rate=FAST)
    moves = read(data.draw(prints(firmware, DRAWN[:2], 10)), machine).moves
    modes = ((False, True), (False, False), (True, True))
    first, *others = (compensated(told_anew(moves, *mode), machine, LPFBS) for mode in modes)
    for other in others:
        same_path(first, other, SAME_PATH_MM[firmware])
        np.testing.assert_allclose(end_of(other.block().moves), end_of(first.block().moves), atol=POSITION_MM)


@each_firmware
@few
@given(st.data(), st.sampled_from((LPFBS, ZV, NONE)))
def test_no_segment_is_without_length(firmware, data, how):
    """A firmware drops those, and their time; the file's own lines may be so."""
    kinds = (*DRAWN, "relative", "wait", "limits")
    written = compensated(data.draw(prints(firmware, kinds)), printer(firmware), how)
    block = written.block()
    own = {bare(line) for line in written.source.splitlines()}
    still = (block.kind == Kind.MOTION) & ~np.isnan(block.lines.words["X"])
    still[block.moves.line] = False
    assert {bare(block.lines.raw(i)) for i in np.flatnonzero(still)} <= own


@each_firmware
def test_moves_of_z_and_e_alone_pass_as_they_were_written(firmware):
    text = START + "G1 X120 Y100 E1 F3000\nG1 E-0.8 F2100\nG1 Z0.7 F900\nG1 X100 Y100 F9000\nG1 Z0.3\n"
    text += "G1 E0.8 F2100\nG1 X110 E1 F3000\n"
    lines = compensated(text, printer(firmware), LPFBS).lines
    assert in_order([b"G1 E-0.8 F2100", b"G1 Z0.7 F900", b"G1 Z0.3", b"G1 E0.8 F2100"], lines) is None
    before = lines[lines.index(b"G1 Z0.3") - 1]
    assert before == b"G1 F9000", "its F is put back"


@each_firmware
def test_a_file_without_motion_is_its_text_and_the_stamp(firmware):
    text = b"; generated by a test\nM104 S200\nM117 Hello\nG4 P100\nG28\nM84"
    written = compensated(text, printer(firmware), LPFBS)
    lines = written.lines
    assert lines[1].startswith(b"; fbf ")
    assert [lines[0], *lines[2:]] == text.splitlines() and written.text.endswith(b"\n")
    assert written.done.summary.segments == 0 and written.done.time == pytest.approx(0.1)


def test_an_empty_file_is_refused():
    with pytest.raises(GcodeError, match="empty"):
        compensated(b"")


@each_firmware
def test_time_lines_tell_the_time_of_the_written_file(firmware):
    text = "; generated by a test\n;TIME:99\nM73 P0 R9\n" + START
    text += "G1 X120 Y100 E1 F600\nM73 P50 R5\nG1 X100 Y100 E1 F300\nM400\nM73 P100 R0\n"
    written = compensated(text, printer(firmware), Settings(method="lpfbs"))
    total = written.done.time
    lines = [line.rstrip() for line in written.lines]
    assert b";TIME:%d" % round(total) in lines
    told = [line for line in lines if line.startswith(b"M73")]
    assert [line.split()[1] for line in told] == [b"P0", told[1].split()[1], b"P100"]
    half = print_time("\n".join(text.splitlines()[:9]), printer(firmware))
    assert int(told[1].split()[1][1:]) == pytest.approx(100 * half / total, abs=2.0)
    plain = compensated(text, printer(firmware), LPFBS)
    assert plain.done.time == total and b"M73 P50 R5" in plain.lines


@each_firmware
@few
@given(st.integers(0, 2**32 - 1))
def test_nothing_is_written_beyond_the_travel(firmware, seed):
    """Corners and holds on the very edge of what the machine can reach: a step beyond would end the print."""
    rng = np.random.default_rng(seed)
    corners = rng.choice([80.0, 80.0, 120.0, 120.0, 100.0], (12, 2))
    lines = [f"G1 X{x:.3f} Y{y:.3f} E0.5 F{rng.choice([3000, 9000, 15000])}" for x, y in corners]
    machine = printer(firmware)
    axes = tuple(replace(axis, travel=(80.0, 120.0)) for axis in machine.axes[:2])
    edged = replace(machine, axes=(*axes, machine.axes[2]))
    written = compensated(START + "\n".join(lines) + "\n", edged, LPFBS)
    moves = written.block().moves
    end = moves.start[:, :2] + moves.delta[:, :2]
    known = moves.line > moves.line[0] + 1
    assert (end[known] >= 80.0).all() and (end[known] <= 120.0).all()
