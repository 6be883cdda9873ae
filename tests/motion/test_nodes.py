"""Laws of break points and of the fit between them."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from fbfcli.motion.budget import BURST, Budget
from fbfcli.motion.nodes import break_points, thinned
from fbfcli.motion.polyline import Polyline

DT = 1e-3
TOLERANCE = 5e-3
FREE = Budget(TOLERANCE, 1.0 / DT)  # a node at every sample is allowed


def stretches(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """A command from rest to rest, `count` times, and the first and last samples: a smoothed random walk."""
    rng = np.random.default_rng(seed)
    pieces, ends, n, at = [], [], 0, np.zeros(2)
    for _ in range(count):
        length = int(rng.integers(60, 400))
        v = np.repeat(rng.normal(0, rng.choice((0.5, 20.0, 150.0)), (length // 20 + 1, 2)), 20, axis=0)[:length]
        v[:15] = v[-15:] = 0.0
        kernel = np.ones(12) / 12
        v = np.column_stack([np.convolve(np.convolve(v[:, i], kernel, "same"), kernel, "same") for i in (0, 1)])
        v[0] = v[-1] = 0.0
        u = at + np.cumsum(v, axis=0) * DT
        pieces.append(u)
        ends += [n, n + length - 1]
        n, at = n + length, u[-1]
    return np.concatenate(pieces), np.array(ends)


SEEDS = st.integers(0, 2**32 - 1)
NONE = np.zeros(0, dtype=np.int64)
motions = (SEEDS, st.integers(1, 3))
forced_samples = st.lists(st.integers(1, 5000), max_size=6)
BUDGETS = (FREE, Budget(TOLERANCE, 100.0), Budget(TOLERANCE, 100.0, 0.075), Budget(0.1, 50.0, 0.0, 0.5))


def forced_in(u: np.ndarray, samples: list[int]) -> np.ndarray:
    return np.unique([1 + sample % (len(u) - 2) for sample in samples]).astype(np.int64)


def chord_error(u: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Largest distance of u from its chords along X or Y, shape (len(u),)."""
    chords = Polyline(nodes, np.zeros(len(nodes), dtype=bool))
    return np.maximum(*(np.abs(chords.curve(u[nodes, i]) - u[:, i]) for i in (0, 1)))


@given(*motions, forced_samples, st.sampled_from(BUDGETS))
def test_ends_and_forced_samples_are_nodes(seed, count, samples, budget):
    u, ends = stretches(seed, count)
    forced = forced_in(u, samples)
    nodes = break_points(u, ends, forced, DT, budget)
    assert (np.diff(nodes) > 0).all() and nodes[0] == 0 and nodes[-1] == len(u) - 1
    assert np.isin(ends, nodes).all()
    assert np.isin(forced, nodes).all() or budget.min_length > 0 or budget.min_speed > 0, "only short ones are given up"


@given(*motions, forced_samples)
def test_chords_keep_the_tolerance_where_the_firmware_allows_it(seed, count, samples):
    u, ends = stretches(seed, count)
    forced = forced_in(u, samples)
    nodes = break_points(u, ends, forced, DT, FREE)
    assert chord_error(u, nodes).max() <= 1.5 * TOLERANCE + 1e-12


@given(*motions, st.floats(50.0, 400.0))
@example(169123694, 1, 164.0)
def test_the_firmware_gets_no_more_segments_than_it_takes(seed, count, rate):
    """In the long run, and BURST at once; two at the ends, and a quarter: prices follow in a few rounds."""
    u, ends = stretches(seed, count)
    nodes = break_points(u, ends, NONE, DT, Budget(TOLERANCE, rate))
    for a, b in zip(ends[::2], ends[1::2], strict=True):
        found = np.count_nonzero((nodes > a) & (nodes <= b))
        assert found <= 1.25 * (rate * (b - a) * DT + BURST) + 2


@given(*motions, st.floats(0.01, 0.2))
def test_no_segment_is_shorter_than_the_firmware_keeps_unless_the_stretch_is(seed, count, least):
    u, ends = stretches(seed, count)
    nodes = break_points(u, ends, NONE, DT, Budget(TOLERANCE, 300.0, least))
    step = np.max([np.abs(np.diff(u[nodes, i])) for i in (0, 1)], axis=0)
    short = np.flatnonzero(step < least)
    first = nodes[short]
    stretch = np.searchsorted(ends[::2], first, side="right") - 1
    gap = np.isin(first, ends[1::2])
    whole = np.isin(first, ends[::2]) & np.isin(nodes[short + 1], ends[1::2])
    assert (gap | whole | (stretch < 0)).all()


@given(*motions, forced_samples)
def test_a_tighter_tolerance_takes_no_fewer_nodes(seed, count, samples):
    u, ends = stretches(seed, count)
    forced = forced_in(u, samples)
    counts = [len(break_points(u, ends, forced, DT, Budget(t, 1.0 / DT))) for t in (0.1, 0.01, 0.001)]
    assert counts[0] <= counts[1] + 2 and counts[1] <= counts[2] + 2


def test_a_straight_line_at_constant_speed_needs_few_nodes():
    u = np.column_stack([np.linspace(0, 100, 2001), np.zeros(2001)])
    nodes = break_points(u, np.array([0, 2000]), NONE, DT, FREE)
    assert len(nodes) <= 10


@given(st.lists(st.integers(0, 5000), max_size=50, unique=True), st.floats(20, 1000))
def test_thinned_samples_are_among_the_wanted_and_no_denser_than_the_rate(wanted, rate):
    wanted = np.array(sorted(wanted), dtype=np.int64)
    kept = thinned(wanted, DT, Budget(TOLERANCE, rate))
    assert np.isin(kept, wanted).all()
    if len(wanted):
        assert kept[0] == wanted[0]
        slots = 5000 * DT * rate
        assert len(kept) <= slots + 1
