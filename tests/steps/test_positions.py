"""Positions as halstreamer reads them: a line per period, a float for each pin."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from step_cases import DT, MOTORS, NS, motions

from fbfcli.steps.curve import position
from fbfcli.steps.positions import PositionsWriter, read_positions
from fbfcli.steps.stream import Motors, Piece, Steps, no_steps

ROUNDING = 0.5e-6 + 1e-9  # mm: six decimals
LONGEST = 4000  # BUF_SIZE of halstreamer


def written(tick: np.ndarray, q: np.ndarray, rate: float, cuts: tuple[int, ...] = ()) -> bytes:
    """The file of positions that come in pieces; the stream ends with the last one."""
    writer = PositionsWriter(Motors(MOTORS.names[: q.shape[1]], MOTORS.steps_per_mm[: q.shape[1]]), rate, DT)
    edges = [0, *sorted(cuts), len(q)]
    parts = [*writer.head()]
    for a, b in pairwise(edges):
        parts += writer.add(Piece(Steps(0, int(tick[-1]) * NS, (no_steps(),)), tick[a:b], q[a:b]))
    return b"".join([*parts, *writer.end()])


@given(x=motions(), y=motions(), data=st.data())
def test_at_the_trajectorys_rate_a_line_is_a_sample(x, y, data):
    n = min(len(x), len(y))
    q = np.column_stack([x[:n], -y[:n]])
    cuts = data.draw(st.lists(st.integers(0, n), max_size=5))
    read = read_positions(written(np.arange(n), q, 1000.0, tuple(cuts)))
    assert read.shape == q.shape
    assert np.abs(read - q).max() <= ROUNDING


@given(x=motions(), rate=st.sampled_from([200.0, 333.0, 1000.0, 4000.0, 7321.5]))
def test_at_any_rate_a_line_is_on_the_curve(x, rate):
    read = read_positions(written(np.arange(len(x)), x[:, None], rate))[:, 0]
    at = np.arange(len(read)) / rate / DT
    assert at[-1] <= len(x) - 1 + 1e-6
    assert len(x) - 1 - at[-1] < 1 / rate / DT
    assert np.abs(read - position(x, np.minimum(at, len(x) - 1))).max() <= ROUNDING


def test_a_rest_is_the_same_line_again():
    tick, q = np.array([0, 1, 2, 20_002, 20_003]), np.array([[0.0], [1.0], [1.0], [1.0], [2.0]])
    read = read_positions(written(tick, q, 1000.0, (2, 4)))[:, 0]
    assert read.tolist() == [0.0] + [1.0] * 20_002 + [2.0]


def test_the_text_is_what_halstreamer_documents():
    """Floats in decimal, separated by whitespace, a newline at each end, no line beyond the reader's buffer."""
    q = np.array([[0.0, -1.25, 300.123456], [0.0, 0.0, -0.0000004]])
    text = written(np.arange(2), q, 1000.0)
    assert text == b"0.000000 -1.250000 300.123456\n0.000000 0.000000 0.000000\n"
    assert max(map(len, text.splitlines())) < LONGEST


@pytest.mark.parametrize("text", [b"# a comment\n1.5 2\n", b"  1.5\t2e0 \n", b"1.5 2"])
def test_what_halstreamer_reads_is_read(text):
    assert read_positions(text).tolist() == [[1.5, 2.0]]
