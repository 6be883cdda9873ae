"""Laws of listings: split, joined and selected, lines keep their text and what they are."""

from dataclasses import fields

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from reading_cases import blocks_of, files, whole

from fbfcli.errors import GcodeError
from fbfcli.gcode.listing import Listing, join, listing


def same(a: Listing, b: Listing) -> None:
    assert [a.raw(i) for i in range(len(a))] == [b.raw(i) for i in range(len(b))]
    for name in (f.name for f in fields(Listing)):
        if name not in ("text", "begin", "end"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def listed(text: str) -> Listing | None:
    try:
        return listing(whole(text)[0])
    except GcodeError:
        return None


@given(files, st.integers(0, 40))
def test_split_and_joined_is_the_same(text, number):
    full = listed(text)
    if full is None:
        return
    first, rest = full.split(number)
    assert len(first) == min(number, len(full)) and (rest.number >= number).all()
    same(join([first, rest]), full)
    same(join([first, rest[:0], rest, first[:0]]), full)


@given(files, st.integers(1, 200))
def test_listings_of_chunks_join_to_the_listing_of_the_file(text, size):
    full = listed(text)
    if full is None or not len(full):
        return
    parts = [listing(block) for block in blocks_of(text, size=size)[0]]
    joined = join(parts)
    for name in (
        "number",
        "kind",
        "wait",
        "known",
        "has_feed",
        "has_command",
        "feed",
        "motion",
        "xy_relative",
        "e_relative",
        "inch",
    ):
        np.testing.assert_array_equal(getattr(joined, name), getattr(full, name), err_msg=name)
    np.testing.assert_allclose(joined.e_file, full.e_file, rtol=0, atol=1e-6 + 1e-12 * np.abs(full.e_file).max())
    assert b"".join(joined.raw(i) for i in range(len(joined))) == text.encode()


@given(files, st.data())
def test_joining_selected_lines_holds_no_more_text_than_they_span(text, data):
    full = listed(text)
    if full is None or len(full) < 2:
        return
    cut = data.draw(st.integers(1, len(full) - 1))
    tail, head = full[cut:], full[:1]
    joined = join([head, tail])
    assert len(joined.text) == len(head.raw(0)) + sum(len(tail.raw(i)) for i in range(len(tail)))
    assert joined.raw(0) == full.raw(0) and joined.raw(1) == full.raw(cut)


@given(files)
def test_the_modes_after_a_line_give_its_e_offset(text):
    full = listed(text)
    if full is None:
        return
    modes = full.modes(full.e_file + 7.0)
    np.testing.assert_allclose(modes.offset[:, 3], 7.0, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(modes.offset[:, :3], full.offset)
