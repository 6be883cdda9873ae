"""Laws of chords: costs are those of the samples, and no other choice of nodes is cheaper."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.motion.chords import REACH, ROW, cheapest, chord_costs, even_cuts
from fbfcli.motion.polyline import Polyline


def case(seed: int, n: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    """A smooth random command far from zero, and candidates."""
    rng = np.random.default_rng(seed)
    u = 250.0 + np.cumsum(np.cumsum(rng.normal(0, 1e-3, (n, 2)), axis=0), axis=0)
    return u, np.flatnonzero((rng.random(n) < share) | np.isin(np.arange(n), (0, n - 1)))


cases = st.builds(case, st.integers(0, 2**32 - 1), st.integers(2, 900), st.sampled_from((0.05, 0.4, 1.0)))
prices = st.sampled_from((1e-9, 1e-4, 1e-2, 1.0))


@given(cases, st.data())
def test_the_cost_of_a_chord_is_the_sum_of_its_squared_errors(case, data):
    u, at = case
    j = data.draw(st.integers(1, len(at) - 1))
    w = data.draw(st.integers(1, min(REACH, j)))
    a, b = at[j - w], at[j]
    off = u[a:b] - (u[a] + np.linspace(0, 1, b - a, endpoint=False)[:, None] * (u[b] - u[a]))
    found = chord_costs(u, at)[w - 1, j]
    np.testing.assert_allclose(found, np.square(off).sum(), rtol=1e-6, atol=1e-10)


@given(cases)
def test_no_chord_begins_before_the_first_candidate(case):
    u, at = case
    cost = chord_costs(u, at)
    reach, place = np.indices(cost.shape)
    np.testing.assert_array_equal(np.isinf(cost), reach + 1 > place)


def least_total(cost: np.ndarray, price: np.ndarray, cuts: np.ndarray) -> float:
    """Bellman's recursion, one candidate at a time."""
    best = [0.0]
    for j in range(1, cost.shape[1]):
        begin = cuts[np.searchsorted(cuts, j) - 1]
        best.append(min(best[j - w] + cost[w - 1, j] for w in range(1, min(REACH, j - begin) + 1)) + price[j])
    return best[-1]


@given(cases, prices, st.booleans())
def test_no_polyline_through_the_cuts_is_cheaper(case, price, shifted):
    u, at = case
    cost, each = chord_costs(u, at), np.full(len(at), price) * np.linspace(0.5, 2.0, len(at))
    cuts = even_cuts(np.ones(len(at), dtype=bool), 0.5 * shifted)
    nodes = np.flatnonzero(cheapest(cost, each, cuts))
    assert np.isin(cuts, nodes).all() and (np.diff(nodes) <= REACH).all()
    total = cost[np.diff(nodes) - 1, nodes[1:]].sum() + each[nodes[1:]].sum()
    np.testing.assert_allclose(total, least_total(cost, each, cuts), rtol=1e-9)


@given(cases, prices)
def test_the_total_is_the_squared_error_of_the_polyline_and_its_price(case, price):
    u, at = case
    cost, each = chord_costs(u, at), np.full(len(at), price)
    found = np.flatnonzero(cheapest(cost, each, np.array([0, len(at) - 1])))
    line = Polyline(at[found], np.zeros(len(found), dtype=bool))
    off = u - np.column_stack([line.curve(u[at[found], i]) for i in (0, 1)])
    total = cost[np.diff(found) - 1, found[1:]].sum()
    np.testing.assert_allclose(total, np.square(off).sum(), rtol=1e-6, atol=1e-9)


@given(st.integers(0, 2**32 - 1), st.integers(2, 2000), st.sampled_from((0.0, 0.5)))
def test_cuts_are_nodes_a_row_apart(seed, m, shift):
    rng = np.random.default_rng(seed)
    is_node = rng.random(m) < 0.3
    is_node[[0, -1]] = True
    cuts = even_cuts(is_node, shift)
    assert cuts[0] == 0 and cuts[-1] == m - 1 and is_node[cuts].all() and (np.diff(cuts) > 0).all()
    longest = np.diff(np.flatnonzero(is_node)).max()
    assert np.diff(cuts).max() <= ROW + longest


@given(cases, st.sampled_from((1e-4, 1e-3)))
def test_dearer_segments_are_fewer(case, price):
    u, at = case
    cost, cuts = chord_costs(u, at), np.array([0, len(at) - 1])
    few, many = (cheapest(cost, np.full(len(at), p), cuts).sum() for p in (100.0 * price, price))
    assert few <= many
