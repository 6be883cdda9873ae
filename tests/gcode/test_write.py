"""Laws of segments as text: whatever the modes, a firmware that reads them goes through the nodes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reading_cases import printer

from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.scan import scan
from fbfcli.gcode.words import SCALE
from fbfcli.gcode.write import Modes, feed_of, power_on_modes, segment_lines, speed_of, words_of
from fbfcli.units import MM_PER_INCH

WORD_MM = {False: 1.0 / SCALE, True: MM_PER_INCH / SCALE}
ONE_MODE = st.tuples(st.booleans(), st.booleans(), st.booleans())


def modes_of(n: int, xy_relative: bool, e_relative: bool, inch: bool, offset=(0.0, 0.0, 0.0, 0.0)) -> Modes:
    full = [np.full(n, flag) for flag in (xy_relative, e_relative, inch)]
    return Modes(*full, np.tile(np.asarray(offset, float), (n, 1)), np.ones(n))


def nodes_of(seed: int, n: int, size: float) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.array([100.0, 80.0, 10.0, 5.0]) + np.cumsum(
        rng.normal(0, 1, (n + 1, 4)) * [size, size, size / 50, size / 20], axis=0
    )


nodes = st.builds(nodes_of, st.integers(0, 2**32 - 1), st.integers(1, 40), st.sampled_from((1e-6, 1e-4, 0.01, 3.0)))


def written(words, modes: Modes) -> bytes:
    """Lines that put a firmware into the modes at the first node, then the segments."""
    x, y, z, e = words.begin[0] / SCALE
    inch, xy, er = modes.inch[0], modes.xy_relative[0], modes.e_relative[0]
    head = ["G20" if inch else "G21", "G90", "M82", f"G1 X{x:.5f} Y{y:.5f} Z{z:.5f} E{e:.5f} F1000"]
    head += ["G91" if xy else "G90", "M83" if er else "M82"]
    text, _ = segment_lines(words, modes, np.full(len(words.real), 6000 * SCALE))
    return "\n".join(head).encode() + b"\n" + text


@given(nodes, ONE_MODE)
def test_a_firmware_goes_through_the_nodes(nodes, mode):
    n = len(nodes) - 1
    modes = modes_of(n, *mode)
    words = words_of(nodes, modes, np.ones(n, bool), np.ones(n + 1, bool))
    machine = printer("reprapfirmware")
    moves = interpret(scan(written(words, modes)), initial_state(machine), machine)[0].moves
    ends = (moves.start + moves.delta)[-n:]
    assert len(moves) == n + 1, "no segment is lost"
    np.testing.assert_allclose(ends, words.end * WORD_MM[mode[2]], atol=1e-9)
    np.testing.assert_allclose(moves.delta[-n:], words.delta, atol=1e-9)
    assert np.abs(ends - nodes[1:])[:, 1:].max() <= 0.51 * WORD_MM[mode[2]], "rounding never adds up"
    assert np.abs(ends - nodes[1:])[:, 0].max() <= 4.51 * WORD_MM[mode[2]], "nor do nudges"


@given(nodes, ONE_MODE, st.data())
def test_no_real_segment_is_without_length_if_its_end_may_move(nodes, mode, data):
    n = len(nodes) - 1
    equal = data.draw(st.lists(st.booleans(), min_size=n, max_size=n))
    for i in np.flatnonzero(equal):
        nodes[i + 1] = nodes[i]
    movable = np.ones(n + 1, bool)
    movable[[0, -1]] = False
    words = words_of(nodes, modes_of(n, *mode), np.ones(n, bool), movable)
    short = (words.begin[:, :3] == words.end[:, :3]).all(axis=1)
    assert not short.any() or n == 1
    np.testing.assert_array_equal(words.begin[1:], words.end[:-1])
    for end, node in ((words.begin[0], nodes[0]), (words.end[-1], nodes[-1])):
        assert np.abs(end * WORD_MM[mode[2]] - node).max() <= 0.51 * WORD_MM[mode[2]], "pinned ends stay"


@given(nodes, st.data())
def test_gaps_are_not_written(nodes, data):
    n = len(nodes) - 1
    real = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    modes = modes_of(n, False, True, False)
    words = words_of(nodes, modes, real, np.ones(n + 1, bool))
    text, offsets = segment_lines(words, modes, np.full(n, SCALE))
    assert text.count(b"\n") == real.sum() and len(offsets) == n + 1
    assert ((np.diff(offsets) > 0) == real).all() and offsets[-1] == len(text)


@given(nodes, st.lists(ONE_MODE, min_size=2, max_size=4), st.integers(0, 2**32 - 1))
def test_modes_that_change_between_segments_change_no_position(nodes, kinds, seed):
    """Offsets (G92) and absolute or relative words: what the machine does stays within half a word."""
    n = len(nodes) - 1
    rng = np.random.default_rng(seed)
    of = np.sort(rng.integers(0, len(kinds), n))
    xy, e, _ = (np.array([kind[i] for kind in kinds])[of] for i in range(3))
    offset = np.round(rng.uniform(-20, 20, (len(kinds), 4)), 3)[of]
    modes = Modes(xy, e, np.zeros(n, bool), offset, np.ones(n))
    words = words_of(nodes, modes, np.ones(n, bool), np.ones(n + 1, bool))
    for word, node in ((words.begin, nodes[:-1]), (words.end, nodes[1:])):
        assert np.abs(word / SCALE + offset - node)[:, 1:].max() <= 0.51 / SCALE
    inner = words.end[:-1] / SCALE + offset[:-1] - words.begin[1:] / SCALE - offset[1:]
    assert np.abs(inner).max(initial=0.0) <= 1.01 / SCALE


@settings(max_examples=50)
@given(st.lists(st.floats(1e-3, 5000), min_size=1), st.sampled_from((1.0, MM_PER_INCH)), st.floats(0.1, 10.0))
def test_a_speed_read_from_its_word_is_the_speed(speeds, unit, factor):
    v, unit_array, factors = np.array(speeds), np.full(len(speeds), unit), np.full(len(speeds), factor)
    again = speed_of(feed_of(v, unit_array, factors), unit_array, factors)
    np.testing.assert_allclose(again, v, rtol=6e-6, atol=unit * factor / 60 / SCALE)


def test_e_and_z_words_stand_only_where_they_change():
    nodes = np.array([[0, 0, 1, 0], [1, 0, 1, 0], [2, 0, 1, 0.5], [3, 0, 1.1, 0.5]], float)
    modes = modes_of(3, False, True, False)
    words = words_of(nodes, modes, np.ones(3, bool), np.ones(4, bool))
    text, _ = segment_lines(words, modes, np.full(3, 600 * SCALE))
    assert text == b"G1 X1 Y0 F600\nG1 X2 Y0 E0.5 F600\nG1 X3 Y0 Z1.1 F600\n"


def test_modes_join_and_select():
    one = power_on_modes()
    other = replace(one, inch=np.ones(1, bool), speed_factor=np.array([0.5]))
    both = one.then(other)
    assert both.inch.tolist() == [False, True] and both.offset.shape == (2, 4)
    assert both[np.array([1])].speed_factor == pytest.approx([0.5])
