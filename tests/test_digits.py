"""Laws of numbers as text: every digit, and nothing else."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.digits import AT_ONCE, chosen, decimal, fixed, only, rows

values = st.lists(st.one_of(st.integers(-(10**17), 10**17), st.integers(-(10**6), 10**6)), min_size=1, max_size=30)


def as_written(value: int, places: int) -> str:
    digits = str(abs(value)).rjust(places + 1, "0")
    whole, part = digits[: len(digits) - places], digits[len(digits) - places :]
    return "-" * (value < 0) + whole + ("." + part if places else "")


@given(values, st.integers(0, 9))
def test_a_number_has_all_its_digits(values, places):
    text = rows(len(values), decimal(np.array(values), places), fixed(b"\n"))
    assert text.decode().split("\n") == [*(as_written(value, places) for value in values), ""]


@given(values, st.data())
def test_cells_are_written_where_they_are_wanted(values, data):
    count = len(values)
    where = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    which = np.array(data.draw(st.lists(st.integers(0, 2), min_size=count, max_size=count)))
    texts = [b"", b"a word of two pieces", b"short"]
    text = rows(count, only(decimal(np.array(values)), where), fixed(b"|"), chosen(texts, which), fixed(b"\n"))
    wanted = [
        (str(value) if there else "") + "|" + texts[k].decode()
        for value, there, k in zip(values, where, which, strict=True)
    ]
    assert text.decode().split("\n") == [*wanted, ""]


def test_many_rows_are_as_few():
    value = np.arange(-AT_ONCE, AT_ONCE + 7)
    text = rows(len(value), decimal(value, 3), fixed(b"\n")).decode()
    assert text.split() == [as_written(v, 3) for v in value.tolist()]
