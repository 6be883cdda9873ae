"""Bytes of a file to columns of words. Every line is kept verbatim; motion words are decoded as arrays.

How a chunk is read: comments are removed, blanks deleted, letters made capital. What is left is a string of words, each
a letter and a number, so the letters' positions say where every number begins and ends. The digits of a number, without
its point, are eight bytes of memory (or more), and three multiplications turn eight ASCII digits into an integer
("SIMD within a register", D. Lemire, 2022), here for all numbers of a chunk at once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from fbfcli.errors import GcodeError

G0, G1, G2, G3, G5, MODAL = 0, 1, 2, 3, 5, 9  # motion: `code` of a line is its G number, MODAL has no G word
BLANK, OTHER, ODD = -1, -2, -3  # nothing but comment; any other command; a line that wants a grammar
LETTERS = "XYZEFIJRPQS"  # words a motion line may have
MAX_DIGITS = 24  # up to 15 the number is the nearest double (integer and power of ten are exact), then within 2 ulp
MAX_LINE = 1 << 24  # bytes; no text file has such a line

_CAPITALS = bytes(range(256)).upper()
_BLANKS = b" \t\r\v\f"
_SEMICOLON = re.compile(rb";[^\n]*")
_COMMENT = re.compile(rb";[^\n]*|\([^)\n]*\)?")
_EXPONENT = re.compile(rb"[ \t][XYZF][-+]?[0-9.]*[0-9][eE][-+]?[0-9]{2}", re.IGNORECASE)
_PAD = b"0" * MAX_DIGITS  # so that eights of bytes can be read from before the first digit
_EIGHT = np.array([(0x0F0F0F0F0F0F0F0F << (64 - 8 * min(n, 8))) % (1 << 64) for n in range(256)], dtype=np.uint64)
_TEN = 10.0 ** np.arange(MAX_DIGITS + 1)


@dataclass(frozen=True)
class Lines:
    """n lines of one chunk of a file.

    text       : bytes                                    the chunk
    begin, end : ndarray of int, shape (n,)               line i is text[begin[i]:end[i]], newline included
    code       : ndarray of int16, shape (n,)             G0 G1 G2 G3 G5 MODAL, BLANK, OTHER or ODD
    words      : dict letter -> ndarray, shape (n,)       value of each of LETTERS on motion lines, nan where absent
    first      : int                                      number (from 0) of line 0 within the file
    """

    text: bytes
    begin: np.ndarray
    end: np.ndarray
    code: np.ndarray
    words: dict[str, np.ndarray]
    first: int

    def __len__(self) -> int:
        return len(self.code)

    def raw(self, i: int) -> bytes:
        """Line i as it stands in the file."""
        return self.text[self.begin[i] : self.end[i]]


def chunks(stream: BinaryIO, size: int = 1 << 19) -> Iterator[bytes]:
    """Whole lines of about `size` bytes together; the last may lack its newline. Raises GcodeError for binary files."""
    parts: list[bytes] = []
    new = True
    while block := stream.read(size):
        if new:
            _refuse_binary(block)
            new = False
        cut = block.rfind(b"\n") + 1
        if cut:
            yield b"".join([*parts, block[:cut]])
            parts = [block[cut:]] if cut < len(block) else []
        else:
            parts.append(block)
        if sum(map(len, parts)) > MAX_LINE:
            raise GcodeError("a line is longer than 16 MB", remedy="is this file G-code?")
    if parts:
        yield b"".join(parts)


def _refuse_binary(block: bytes) -> None:
    if block.startswith(b"GCDE"):
        raise GcodeError(
            "this is binary G-code, fbf reads text",
            remedy="in PrusaSlicer switch off Printer Settings > General > Firmware > Supports binary G-code, "
            "or convert the file with bgcode",
        )
    if b"\0" in block:
        raise GcodeError("this is a binary file, not G-code text", remedy="export the part as plain-text G-code")


def scan(text: bytes, first: int = 0) -> Lines:
    """Lines of `text`, which ends at a line end or at the end of the file."""
    newline = np.flatnonzero(np.frombuffer(text, np.uint8) == ord("\n"))
    end = newline + 1
    if text and not text.endswith(b"\n"):
        end = np.append(end, len(text))
    begin = np.concatenate(([0], end[:-1])) if len(end) else end
    if not len(end):
        return Lines(text, begin, end, np.empty(0, np.int16), dict.fromkeys(LETTERS, np.empty(0)), first)
    words = _Words.of(_without_comments(text))
    code = words.codes()
    lines = Lines(text, begin, end, code, words.columns(code), first)
    _refuse_exponents(lines)
    return lines


def _refuse_exponents(lines: Lines) -> None:
    """A motion line with spaced words and a number like 1e300: firmwares read X1 E300, which nobody means."""
    byte = np.frombuffer(lines.text, np.uint8)
    e = np.flatnonzero((byte[1:] | 0x20) == ord("e"))
    e = e[(byte[e] - ord("0")) <= 9]
    line = np.unique(np.searchsorted(lines.begin, e, side="right") - 1)
    for i in line[lines.code[line] != BLANK].tolist():
        raw = lines.raw(i).partition(b";")[0]
        if raw.lstrip()[:1] in (b"G", b"g") and _EXPONENT.search(raw):
            raise GcodeError("numbers in G-code have no exponents", line=lines.first + i + 1,
                             text=lines.raw(i).decode("utf-8", "replace"), remedy="write the number out")  # fmt: skip


def _without_comments(text: bytes) -> bytes:
    """Code of each line, the last line ended; both kinds of comment removed."""
    code = _SEMICOLON.sub(b"", text)
    if b"(" in code:
        code = _COMMENT.sub(b" ", text)
    return code if text.endswith(b"\n") else code + b"\n"


def _letters(chosen: str) -> np.ndarray:
    """Table of 256 truth values: is this byte one of `chosen`?"""
    table = np.zeros(256, bool)
    table[list(chosen.encode())] = True
    return table


_ON_MOTION_LINE = _letters(LETTERS)
_MODAL_HEAD = _letters("XYZEFIJR")


@dataclass(frozen=True)
class _Words:
    """Words of a chunk, k of them; a line begins with the newline of the line before it.

    letter : ndarray of uint8, shape (k,)   capital, or newline
    value  : ndarray, shape (k,)            its number; anything where `bad`
    whole  : ndarray of bool, shape (k,)    the number has neither point nor sign
    bad    : ndarray of bool, shape (k,)    no number, or not one that is decoded exactly
    first  : ndarray of int, shape (n + 1,) index of the newline that opens each line, and of the last one
    """

    letter: np.ndarray
    value: np.ndarray
    whole: np.ndarray
    bad: np.ndarray
    first: np.ndarray

    @classmethod
    def of(cls, code: bytes) -> _Words:
        text = (b"\n" + code).translate(_CAPITALS, _BLANKS)
        byte = np.frombuffer(text, np.uint8)
        signed = (byte == ord("+")) | (byte == ord("-"))
        mark = np.flatnonzero(((byte - ord("0")) > 9) & ~signed)  # everything that ends a run of digits
        kind = byte[mark]
        word = np.flatnonzero(kind != ord("."))
        letter, place = kind[word], mark[word]
        points = np.diff(word, append=len(mark)) - 1
        pointed = np.flatnonzero(points)
        decimals = np.zeros(len(word), np.int64)
        decimals[pointed] = place[pointed + 1] - mark[word[pointed] + 1] - 1
        sign = byte[np.minimum(place + 1, len(byte) - 1)]
        has_sign = (sign == ord("-")) | (sign == ord("+"))
        digits = np.diff(place, append=len(text)) - 1 - points - has_sign
        value = _decode(text.translate(None, b"."), place - (word - np.arange(len(word))), digits, decimals)
        np.negative(value, where=sign == ord("-"), out=value)
        bad = (digits < 1) | (digits > MAX_DIGITS) | (points > 1)
        bad[_words_at(place, _misplaced(byte, signed))] = True
        first = np.flatnonzero(letter == ord("\n"))
        bad[first] = (digits[first] > 0) | has_sign[first] | (points[first] > 0)  # a line that begins with a number
        broken = np.searchsorted(np.flatnonzero(np.frombuffer(code, np.uint8) == ord("\n")), _broken_numbers(code))
        bad[first[broken]] = True
        return cls(letter, value, (points == 0) & ~has_sign, bad, first)

    def codes(self) -> np.ndarray:
        """Code of each line, shape (n,)."""
        opening, last = self.first[:-1], self.first[1:]
        head = opening + 1
        numbered = self.letter[head] == ord("N")
        head = head + (numbered & ~self.bad[head])
        letter = self.letter[head]
        number = np.where(self.whole[head] & ~self.bad[head] & (letter == ord("G")), self.value[head], -1.0)
        code = np.full(len(head), OTHER, np.int16)
        for g in (G0, G1, G2, G3, G5):
            code[number == g] = g
        code[_MODAL_HEAD[letter]] = MODAL
        code[(head == last) | (letter == ord("*"))] = BLANK
        wrong = self.bad | ~_ON_MOTION_LINE[self.letter]
        star = np.flatnonzero(self.letter == ord("*"))
        wrong[star] &= self.letter[star + 1] != ord("\n")
        wrong[opening + 1] &= ~(numbered & ~self.bad[opening + 1])
        wrong[head] &= ~((code >= 0) & (code <= G5))
        wrong[self.first] = self.bad[self.first]
        line = np.searchsorted(opening, np.flatnonzero(wrong), side="right") - 1
        code[line[code[line] != OTHER]] = ODD
        return self._several_commands(code, head)

    def _several_commands(self, code: np.ndarray, head: np.ndarray) -> np.ndarray:
        """`code` with ODD for lines like `G17 G90 G21`; other commands may have G in their text (M117 Go)."""
        g = np.flatnonzero((self.letter == ord("G")) & ~self.bad)
        line = np.searchsorted(self.first, g, side="right") - 1
        second = line[(g != head[line]) & (self.letter[head[line]] == ord("G")) & ~self.bad[head[line]]]
        code[second] = ODD
        return code

    def columns(self, code: np.ndarray) -> dict[str, np.ndarray]:
        """Value of each letter on each motion line, nan where absent; a letter that comes twice makes `code` ODD."""
        absent = np.full(len(code), np.nan)
        line = np.repeat(np.arange(len(code) + 1), np.diff(self.first, append=len(self.letter)))
        columns = {}
        for name in LETTERS:
            at = np.flatnonzero(self.letter == ord(name))
            on = line[at]
            motion = code[on] >= 0
            at, on = at[motion], on[motion]
            columns[name] = absent
            if len(at):
                columns[name] = np.full(len(code), np.nan)
                columns[name][on] = self.value[at]
                code[on[1:][on[1:] == on[:-1]]] = ODD
        return columns


def _decode(text: bytes, place: np.ndarray, digits: np.ndarray, decimals: np.ndarray) -> np.ndarray:
    """Numbers that follow the letters at `place` in `text` (capitals, no points), shape (k,)."""
    memory = _PAD + text
    eights = np.ndarray((len(memory) - 7,), np.dtype("<u8"), memory, strides=(1,))  # eight bytes from anywhere
    after = np.append(place[1:], len(text)) + len(_PAD)
    value = _eight_digits(eights[after - 8], digits).astype(float)
    for done in range(8, MAX_DIGITS, 8):  # digits decoded so far
        long = np.flatnonzero((digits > done) & (digits <= MAX_DIGITS))
        value[long] += 10.0**done * _eight_digits(eights[after[long] - done - 8], digits[long] - done).astype(float)
    value /= _TEN[np.minimum(decimals, MAX_DIGITS)]
    return value


def _eight_digits(ascii8: np.ndarray, digits: np.ndarray) -> np.ndarray:
    """Integers from the last `digits` (up to 8) of eight ASCII digits: pairs, then fours, then eights."""
    w = ascii8 & _EIGHT[np.clip(digits, 0, 255)]
    w = w * np.uint64(10 * 256 + 1) >> np.uint64(8)
    w = (w & np.uint64(0x00FF00FF00FF00FF)) * np.uint64(100 * 65536 + 1) >> np.uint64(16)
    return (w & np.uint64(0x0000FFFF0000FFFF)) * np.uint64(10000 * 4294967296 + 1) >> np.uint64(32)


def _misplaced(byte: np.ndarray, signed: np.ndarray) -> np.ndarray:
    """Positions of signs that do not follow a letter."""
    return np.flatnonzero(signed[1:] & ((byte[:-1] - ord("A")) > 25)) + 1


def _words_at(place: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Indices of the words that `position` lies in."""
    return np.searchsorted(place, position, side="right") - 1


def _broken_numbers(code: bytes) -> np.ndarray:
    """Positions where blanks stand between two parts of a number, as in `X1 2`."""
    byte = np.frombuffer(code, np.uint8)
    part = ((byte - ord("+")) <= 14) & (byte != ord(",")) & (byte != ord("/"))  # digits, point, signs
    blank = (byte == ord(" ")) | (byte == ord("\t")) | (byte == ord("\r"))
    at = np.flatnonzero(part[:-2] & blank[1:-1] & (part | blank)[2:]) + 1
    after = at.copy()
    moving = np.arange(len(at))
    while len(moving):
        after[moving] += 1
        moving = moving[blank[after[moving]]]
    return at[part[after]]
