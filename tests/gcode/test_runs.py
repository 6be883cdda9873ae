"""Limits raised and put back over any sequence of barriers, stretches and limit lines."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reading_cases import block_of, files, whole

from fbfcli.errors import GcodeError
from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import Listing, listing
from fbfcli.gcode.placement import Places
from fbfcli.gcode.raised import restore_lines
from fbfcli.gcode.runs import feed_line, is_special, joints, kept_text, raised_where, raising, restoring
from fbfcli.printer import FIRMWARES, Limits

LIMITS = (
    "velocity",
    "acceleration",
    "travel_acceleration",
    "square_corner_velocity",
    "minimum_cruise_ratio",
    "jerk",
    "axis_velocity",
    "axis_acceleration",
)
LINES = st.lists(st.sampled_from(("barrier", "stretch", "kept", "more")), max_size=40)


def followed(kinds: list[str], raised: bool) -> tuple[list[bool], list[bool], bool]:
    """One line at a time: raised before each kept line, at each stretch's beginning, and in the end."""
    lines, begins = [], []
    for kind in kinds:
        if kind == "stretch":
            begins.append(not raised)
            raised = True
        elif kind in ("barrier", "kept"):
            lines.append(raised)
            raised = raised and kind != "barrier"
    return lines, begins, raised


def arrays(kinds: list[str], first: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kept lines, barriers among them, and lines that begin stretches ("more": a line of a stretch begun before)."""
    at = {kind: [first + i for i, k in enumerate(kinds) if k == kind] for kind in ("barrier", "stretch", "kept")}
    return (
        np.array(sorted(at["kept"] + at["barrier"]), int),
        np.array(at["barrier"], int),
        np.array(at["stretch"], int),
    )


@given(LINES, st.booleans())
def test_runs_are_followed_as_one_line_at_a_time_would(kinds, before):
    found = raised_where(*arrays(kinds), before)
    lines, begins, after = followed(kinds, before)
    assert (found.line.tolist(), found.begin.tolist(), found.after) == (lines, begins, after)


@given(LINES, st.integers(0, 40), st.booleans())
def test_runs_in_two_parts_are_the_runs(kinds, cut, before):
    whole = raised_where(*arrays(kinds), before)
    first = raised_where(*arrays(kinds[:cut]), before)
    second = raised_where(*arrays(kinds[cut:], cut), first.after)
    np.testing.assert_array_equal(np.concatenate([first.line, second.line]), whole.line)
    np.testing.assert_array_equal(np.concatenate([first.begin, second.begin]), whole.begin)
    assert second.after == whole.after


@given(LINES)
def test_raising_and_putting_back_alternate(kinds):
    found = raised_where(*arrays(kinds), False)
    number, barrier, starts = arrays(kinds)
    restores = number[found.line & np.isin(number, barrier)]
    events = sorted([(line, "up") for line in starts[found.begin]] + [(line, "down") for line in restores])
    names = [name for _, name in events]
    assert names == ["up", "down"] * (len(names) // 2) + ["up"] * (len(names) % 2)
    assert found.after == (len(names) % 2 == 1)


def places(text: str, firmware: str = "marlin", moves: bool = False) -> Places:
    lines: Listing = listing(block_of(text, firmware))
    n = len(lines)
    return Places(lines, np.zeros(n), np.zeros(n), np.zeros(n), np.full(n, moves), lines.kind == int(Kind.BARRIER))


@pytest.mark.parametrize("firmware", FIRMWARES)
@given(st.floats(100, 20000), st.floats(50, 500), st.floats(1, 30))
def test_what_is_raised_is_put_back(firmware, acceleration, velocity, corner):
    limits = Limits(
        velocity=velocity,
        acceleration=acceleration,
        travel_acceleration=acceleration / 2,
        square_corner_velocity=corner,
        axis_velocity=(velocity, velocity + 1, 10.0, 20.0),
        axis_acceleration=(9000.0, 8000.0, 100.0, 500.0),
        jerk=(corner, corner / 2, 0.4, 3.0),
    )
    mine = "\n".join([*restore_lines(firmware, limits, Limits()), ""])
    up, down = raising(firmware, limits).decode(), restoring(firmware, limits, limits, 600.0).decode()
    block = block_of(mine + up + down, firmware)
    in_force = [block.moves.limits[i] for i in block.state]
    own, high, back = in_force[mine.count("\n") - 1], in_force[(mine + up).count("\n") - 1], in_force[-1]
    for name in LIMITS:
        np.testing.assert_allclose(getattr(back, name), getattr(own, name), rtol=1e-6, atol=1e-6, err_msg=name)
    assert high.acceleration >= 1e6 and block.feed[-1] == 600.0
    if firmware != "klipper":
        kept = 3 if firmware == "marlin" else 4  # Marlin's of E is raised: moves of E alone obey M204 R
        assert high.axis_acceleration[2:kept] == own.axis_acceleration[2:kept] and high.jerk[2:] == own.jerk[2:]
        assert high.axis_velocity[2:] == own.axis_velocity[2:]


@pytest.mark.parametrize("firmware", ("marlin", "reprapfirmware"))
def test_what_a_run_deferred_for_z_and_e_is_in_force_after_it(firmware):
    base = Limits(axis_velocity=(9.0, 9.0, 9.0, 9.0), axis_acceleration=(90.0,) * 4, jerk=(5.0,) * 4)
    limits = replace(base, axis_acceleration=(90.0, 80.0, 70.0, 60.0), jerk=(5.0, 4.0, 3.0, 2.0), acceleration=777.0)
    text = b"".join([raising(firmware, base), restoring(firmware, limits, base, 600.0)])
    block = block_of(text, firmware)
    back = block.moves.limits[block.state[-1]]
    assert (back.axis_acceleration, back.acceleration) == (limits.axis_acceleration, 777.0)
    np.testing.assert_allclose(back.jerk, limits.jerk)


@given(st.floats(0.01, 30000))
def test_the_feed_put_back_is_the_feed(feed):
    line = feed_line(feed)
    assert float(line.split(b"F")[1]) == pytest.approx(feed, abs=5.1e-6) and b"e" not in line.lower()


def test_before_the_first_feed_the_firmwares_own_is_put_back():
    """25 mm/s, as moves without one are planned."""
    assert feed_line(np.nan) == b"G1 F1500\n"


@pytest.mark.parametrize("raised", (False, True))
def test_limit_lines_wait_as_comments_inside_a_run_only(raised):
    text = kept_text(places("M204 S500\n"), 0, raised, b"", None)
    assert text == (b"; fbf: M204 S500\n" if raised else b"M204 S500\n")


def test_limits_are_put_back_before_a_barrier():
    assert kept_text(places("G4 P10\n"), 0, True, b"BACK\n", None) == b"BACK\nG4 P10\n"
    assert kept_text(places("G4 P10\n"), 0, False, b"", None) == b"G4 P10\n"


@pytest.mark.parametrize(
    "raw, kept",
    [
        ("N10 M106 S3*71", b"M106 S3\n"),
        ("N10M106 S3*71 \r\n", b"M106 S3\r\n"),
        ("  n7 M117 a*b", b"M117 a*b\n"),
        ("M117 N5 *is* here\n", b"M117 N5 *is* here\n"),
        ("N10 M106 S3 *71 ; five *2\n", b"M106 S3; five *2\n"),
        ("; a comment*12", b"; a comment*12\n"),
        ("\tM106\n", b"\tM106\n"),
    ],
)
def test_line_numbers_and_checksums_go_and_nothing_else(raw, kept):
    assert kept_text(places(raw), 0, False, b"", None) == kept


@pytest.mark.parametrize(
    "raw, kept",
    [
        ("G92 E0\n", b"G92 E0.12345\n"),
        ("g92e0", b"g92E0.12345\n"),
        ("G092 E0 ; layer\n", b"G092 E0.12345 ; layer\n"),
        ("M82\n", b"M82\n"),
        ("G92.1\n", b"G92.1\n"),
    ],
)
def test_only_g92_states_e_anew(raw, kept):
    assert kept_text(places(raw), 0, True, b"", 12345) == kept


@pytest.mark.parametrize(
    "text, i, kept",
    [
        ("G1 Z5 F900\nG1 Z6\n", 1, b"G1 F900\nG1 Z6\n"),
        ("G1 Z5 F900\nG1 Z6 F300\n", 1, b"G1 Z6 F300\n"),
        ("G1 Z5 F900\nZ6\n", 1, b"G1 F900\nZ6\n"),
    ],
)
def test_motion_that_stays_says_its_feed_inside_a_run(text, i, kept):
    assert kept_text(places(text, moves=True), i, True, b"", None) == kept


def test_modal_motion_that_stays_says_its_own_command():
    """The line that puts F back makes G1 modal."""
    found = kept_text(places("G2 X5 I2.5 F900\nX9 I2\n", moves=True), 1, True, b"", None)
    assert found == b"G1 F900\nG2 X9 I2\n"


@pytest.mark.parametrize("kind", [Kind.BLANK, Kind.IN_ORDER, Kind.PROGRESS])
def test_other_lines_are_verbatim(kind):
    raw = {Kind.BLANK: "; a\r\n", Kind.IN_ORDER: "M106 S3 ; fan\n", Kind.PROGRESS: "M73 P3 R5\n"}[kind]
    assert kept_text(places(raw), 0, True, b"BACK", None) == raw.encode()


@given(files, st.booleans(), st.booleans())
def test_lines_that_are_not_special_are_verbatim(text, raised, moves):
    try:
        lines = listing(whole(text + "\n")[0])
    except GcodeError:
        return
    n = len(lines)
    found = Places(lines, np.zeros(n), np.zeros(n), np.zeros(n), np.full(n, moves), lines.kind == int(Kind.BARRIER))
    special = is_special(found, np.full(n, raised))
    for i in np.flatnonzero(~special):
        assert kept_text(found, int(i), raised, b"BACK\n", None) == lines.raw(i)


@given(files, st.data())
def test_pieces_between_joints_are_the_text_of_their_lines(text, data):
    try:
        full = listing(whole(text + "\n")[0])
    except GcodeError:
        return
    keep = np.array(data.draw(st.lists(st.booleans(), min_size=len(full), max_size=len(full))), bool)
    lines = full[keep]
    if not len(lines):
        return
    special = np.array(data.draw(st.lists(st.booleans(), min_size=len(lines), max_size=len(lines))), bool)
    at = np.flatnonzero(joints(lines, special))
    pieces = [lines.text[lines.begin[a] : lines.end[b - 1]] for a, b in zip(at, [*at[1:], len(lines)], strict=True)]
    assert b"".join(pieces) == b"".join(lines.raw(i) for i in range(len(lines)))
    assert np.isin(np.flatnonzero(special), at).all()
