"""Laws of words: written and read again they are the same integers."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.gcode.scan import scan
from fbfcli.gcode.words import SCALE, feed_words, g1_lines, to_words

BIGGEST = 10**7 * SCALE - 1  # seven digits before the point
words = st.one_of(
    st.integers(-BIGGEST, BIGGEST), st.integers(-2 * SCALE, 2 * SCALE), st.integers(-300, 300).map(lambda n: n * SCALE)
)
rows = st.lists(st.tuples(words, words, words, st.booleans()), min_size=1, max_size=30)


@given(rows)
def test_words_read_back_are_the_same_integers(rows):
    x, y, e, present = (np.array(column) for column in zip(*rows, strict=True))
    text, _ = g1_lines([("X", x, None), ("Y", y, None), ("E", e, present)])
    lines = scan(text)
    assert len(lines) == len(rows)
    np.testing.assert_array_equal(to_words(lines.words["X"]), x)
    np.testing.assert_array_equal(to_words(lines.words["Y"]), y)
    np.testing.assert_array_equal(np.isnan(lines.words["E"]), ~present)
    np.testing.assert_array_equal(to_words(lines.words["E"][present]), e[present])


@given(rows)
def test_offsets_say_where_each_line_begins(rows):
    x, y, e, present = (np.array(column) for column in zip(*rows, strict=True))
    text, offsets = g1_lines([("X", x, None), ("Y", y, None), ("E", e, present)])
    assert offsets[0] == 0 and offsets[-1] == len(text)
    pieces = [text[a:b] for a, b in pairwise(offsets)]
    assert all(piece.startswith(b"G1 X") and piece.endswith(b"\n") and piece.count(b"\n") == 1 for piece in pieces)


@given(words)
def test_a_word_is_the_shortest_form_of_its_number(word):
    text, _ = g1_lines([("X", np.array([word]), None)])
    size = abs(word)
    expected = ("-" if word < 0 else "") + f"{size // SCALE}.{size % SCALE:05d}".rstrip("0").rstrip(".")
    assert text == f"G1 X{expected}\n".encode()


@given(st.lists(st.floats(-9999, 9999), min_size=1))
def test_a_word_is_the_nearest_one(values):
    values = np.array(values)
    assert np.abs(to_words(values) / SCALE - values).max() <= 0.5 / SCALE * (1 + 1e-6)


@given(st.lists(st.floats(1e-9, 1e7), min_size=1))
def test_feed_words_are_positive_and_keep_six_digits(feeds):
    feeds = np.array(feeds)
    found = feed_words(feeds)
    assert (found >= 1).all()
    error = np.abs(found / SCALE - feeds)
    assert (error <= np.maximum(5e-6 * feeds, 1.0 / SCALE)).all()


def test_no_segments_are_no_text():
    none = np.zeros(0, dtype=np.int64)
    text, offsets = g1_lines([("X", none, None), ("F", none, None)])
    assert text == b"" and offsets.tolist() == [0]
