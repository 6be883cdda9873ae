"""The scanner reads every spelling of a motion as a plain parser does, and keeps every byte."""

from __future__ import annotations

import io
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pygcode.words import text2words
from reading_cases import block_of, files, motion_lines

from fbfcli.errors import GcodeError
from fbfcli.gcode.scan import BLANK, G0, G1, G2, G3, G5, LETTERS, MODAL, ODD, OTHER, chunks, scan

WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")


def plain(line: str) -> dict[str, float]:
    """Words of a motion line, the simple way."""
    code = re.sub(r"\(.*?\)", " ", line.split(";")[0]).upper().split("*")[0]
    return {letter: float(number) for letter, number in WORD.findall(code)}


def words_at(lines, i):
    return {name: column[i] for name, column in lines.words.items() if not np.isnan(column[i])}


@given(st.lists(motion_lines(), min_size=1, max_size=20))
def test_every_spelling_is_read_as_float_reads_it(texts):
    lines = scan("\n".join(texts).encode())
    for i, text in enumerate(texts):
        expected = plain(text)
        expected.pop("N", None)
        g = expected.pop("G", None)
        assert lines.code[i] == (MODAL if g is None else g)
        assert words_at(lines, i) == expected


@given(motion_lines())
def test_pygcode_agrees_where_it_can_read(text):
    code = re.sub(r"\(.*?\)", " ", text.split(";")[0]).upper().split("*")[0].replace("+", "")
    grammar = {word.letter: float(word.value) for word in text2words(code)}
    read = words_at(scan(text.encode()), 0)
    assert read == {letter: value for letter, value in grammar.items() if letter in LETTERS}


@given(st.integers(0, 10**15 - 1), st.integers(0, 15), st.booleans())
def test_numbers_of_fifteen_digits_are_exact(value, decimals, negative):
    digits = f"{value:015d}"
    text = ("-" if negative else "") + digits[: 15 - decimals] + "." + digits[15 - decimals :]
    assert scan(f"G1 X{text}".encode()).words["X"][0] == float(text)


@given(st.text("0123456789", min_size=1, max_size=7), st.text("0123456789", min_size=9, max_size=17))
def test_longer_numbers_lose_two_ulp_at_most(whole, decimals):
    number = float(f"{whole}.{decimals}")
    assert abs(scan(f"G1 X{whole}.{decimals}".encode()).words["X"][0] - number) <= 2 * np.spacing(number)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", BLANK), ("   ", BLANK), ("; G1 X1", BLANK), ("(G1 X1)", BLANK), ("N7", BLANK), ("N7 ; x", BLANK),
        ("\r", BLANK), ("G0 X1", G0), ("g01x5", G1), ("G2 I1", G2), ("G03 J1", G3), ("G5 P1 Q1 X1", G5),
        ("F4000", MODAL), ("X1Y2", MODAL), ("N10 G1 X1*34", G1), ("G1 X1 (Y2) Z3", G1), ("G1", G1), ("G1 X1E3", G1),
        ("G4 P1", OTHER), ("G28 X Y", OTHER), ("G10", OTHER), ("M117 G1 X1", OTHER), ("T0", OTHER), ("PAUSE", OTHER),
        ("SET_FAN_SPEED FAN=x SPEED=1", OTHER), ("M862.3 P \"MK3S\"", OTHER), ("G38.2 X1", OTHER), ("é", OTHER),
        ("G17 G90 G21", ODD), ("G90 G1 X5", ODD), ("G1 X", ODD), ("G1 X--5", ODD), ("G1 X1.2.3", ODD), ("G1 X1 2", ODD),
        ("G1 X1 X2", ODD), ("G1 Xnan", ODD), ("END_PRINT", ODD), ("5 X1", ODD), ("G1 A5", ODD), ("G1 X=5", ODD),
        ("G1 X1" + 24 * "0", ODD), ("G1 X1*5 Y2", ODD), ("G1 X\xe9", ODD), ("-5", ODD), (".5 X1", ODD),
    ],
)  # fmt: skip
def test_codes(text, code):
    neighbours = scan(f"G1 X1\n{text}\nG1 X2\n".encode())
    assert neighbours.code.tolist() == [G1, code, G1]
    assert scan(text.encode() or b"\n").code.tolist() == [code]


@given(files, st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_line_ends_change_nothing(text, newline, last):
    unix = scan(text.encode() + b"\n")
    other = scan(text.replace("\n", newline).encode() + (newline.encode() if last else b""))
    assert len(other) == len(unix) - (not last and text[-1:] in ("", "\n"))
    assert other.code.tolist() == unix.code[: len(other)].tolist()
    for name in LETTERS:
        np.testing.assert_array_equal(other.words[name], unix.words[name][: len(other)])


@given(st.text("G1X2.;(\n\r \xe9", max_size=300).map(lambda text: text.encode("latin-1")), st.integers(1, 50))
def test_every_byte_is_kept(text, size):
    parts = list(chunks(io.BytesIO(text), size))
    assert b"".join(parts) == text
    assert all(part.endswith(b"\n") for part in parts[:-1])
    for part in parts:
        lines = scan(part)
        assert b"".join(lines.raw(i) for i in range(len(lines))) == part


def test_corpus_is_kept_byte_for_byte(corpus_file):
    text = corpus_file.read_bytes()
    first, kept = 0, []
    for chunk in chunks(io.BytesIO(text), 10_000):
        lines = scan(chunk, first)
        first += len(lines)
        kept += [lines.raw(i) for i in range(len(lines))]
    assert b"".join(kept) == text
    assert first == text.count(b"\n") + (not text.endswith(b"\n"))


def test_binary_gcode_is_refused_by_name(corpus):
    with (
        open(corpus / "prusa3d__test_binary_heatshrink_meatpack.bgcode", "rb") as stream,
        pytest.raises(GcodeError, match=r"binary G-code.*bgcode"),
    ):
        next(chunks(stream))
    with pytest.raises(GcodeError, match="binary file"):
        next(chunks(io.BytesIO(b"\x7fELF\0\0")))


def test_a_line_without_end_is_refused(monkeypatch):
    monkeypatch.setattr("fbfcli.gcode.scan.MAX_LINE", 1000)
    with pytest.raises(GcodeError, match="longer than"):
        list(chunks(io.BytesIO(b"G1 " * 1000), 100))


@pytest.mark.parametrize(
    "text",
    [
        "G1 X", "G1 X--5", "G1 X1.2.3", "G1 Xnan", "G1 Xinf Y2", "G1 X1 2", "G1 X-", "G1 X.", "G1 X1 X2", "G1 X5 A3",
        "G1 X=5", "X", "G1 X1e", "5 X1", "G1 X99999999", "G1 X1" + 300 * "0", "G1 X1 F0", "G1 X1 F-5", "G28 G1 X5",
        "G1 X5 G2 I1", "G1 X5 M3",
    ],
)  # fmt: skip
def test_nonsense_is_refused_with_its_place(text):
    with pytest.raises(GcodeError) as caught:
        block_of(f"G90\n; comment\n{text}\n")
    assert caught.value.line == 3
    assert caught.value.text.strip() == text
    assert caught.value.remedy
    assert "\n" not in str(caught.value)
