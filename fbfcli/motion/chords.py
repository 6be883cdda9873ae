"""Chords: which of many candidates should be nodes where every segment has its price.

    u_i    command at candidate i; candidates are samples, more than there may be nodes
    c_ij   squared error of the chord from i to j, summed over its samples [mm^2]
    F_j    least cost of a polyline that ends at candidate j

F_j = min_i (F_i + c_ij + price_j), i among the REACH candidates before j (Bellman 1961, On the approximation of curves
by line segments using dynamic programming, CACM 4, p. 284). Rows of candidates are solved side by side, each from a
node to a node, so that the loop is over the places in a row. Cuts between rows are moved from time to time: a node that
was set may be given up, if a better one is near.
"""

from __future__ import annotations

import numpy as np

REACH = 8  # candidates that a chord may span
ROW = 128  # candidates between nodes that are set: some 0.4 s


class _Axis:
    """Sums over the samples of chords that grow by one candidate at a time, along one axis.

    v  : ndarray, shape (m - 1,)   sum of v between neighbouring candidates, v counted from the first of them
    vv, kv : likewise of v^2 and k v
    Vv, Kv : the same over the whole chord, v and k counted from where it begins
    """

    def __init__(self, u: np.ndarray, at: np.ndarray, k: np.ndarray):
        self.value = u[at]
        v = u[at[0] : at[-1]] - np.repeat(self.value[:-1], np.diff(at))
        self.v, self.vv, self.kv = (np.add.reduceat(samples, at[:-1] - at[0]) for samples in (v, v * v, k * v))
        self.Vv, self.Kv = np.zeros(len(at) - 1), np.zeros(len(at) - 1)

    def cost(self, w: int, dk: np.ndarray, n: np.ndarray, span: np.ndarray, Kk: np.ndarray) -> np.ndarray:
        """c of the chords over w + 1 intervals, those over w grown by one: n samples, dk after the chord begins."""
        begin, value = self.value[: len(span)], self.value[w:]
        dv = value[:-1] - begin
        grown = dv * n
        self.Vv = self.Vv[: len(span)] + self.vv[w:] + dv * (2.0 * self.v[w:] + grown)
        self.Kv = self.Kv[: len(span)] + self.kv[w:] + dk * (self.v[w:] + grown) + dv * (0.5 * n * (n - 1.0))
        s = (value[1:] - begin) / span
        return self.Vv + s * (s * Kk - 2.0 * self.Kv)


def chord_costs(u: np.ndarray, at: np.ndarray) -> np.ndarray:
    """c_ij for chords that span 1 to REACH candidates, shape (REACH, m): row w - 1 column j is that from j - w to j.

    u  : ndarray, shape (n, 2)      command [mm]
    at : ndarray of int, shape (m,) candidates

    With v and k counted from the chord's first sample and s its slope: sum (v - s k)^2 = Vv - 2 s Kv + s^2 Kk.
    """
    m = len(at)
    cost = np.full((REACH, m), np.inf)
    length = np.diff(at)
    k = (np.arange(at[0], at[-1]) - np.repeat(at[:-1], length)).astype(float)
    x, y = (_Axis(u[:, axis], at, k) for axis in range(2))
    for w in range(min(REACH, m - 1)):
        n, dk = length[w:].astype(float), (at[w:-1] - at[: m - 1 - w]).astype(float)
        span = dk + n
        Kk = (span - 1.0) * span * (2.0 * span - 1.0) / 6.0
        cost[w, w + 1 :] = x.cost(w, dk, n, span, Kk) + y.cost(w, dk, n, span, Kk)
    return cost


def even_cuts(is_node: np.ndarray, shift: float) -> np.ndarray:
    """Nodes near every ROW-th candidate, `shift` (0 to 1) rows off, with the first and last candidate, increasing."""
    nodes = np.flatnonzero(is_node)
    place = np.arange(shift * ROW, len(is_node) - 1, ROW)
    return np.unique(np.concatenate([[0], nodes[np.searchsorted(nodes, place)], [len(is_node) - 1]]))


def cheapest(cost: np.ndarray, price: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Candidates that are nodes of the cheapest polyline, bool, shape (m,).

    cost  : ndarray, shape (REACH, m)   from `chord_costs`, inf where a chord may not be
    price : ndarray, shape (m,)         of the segment that ends at each candidate [mm^2]
    cuts  : ndarray of int              candidates that are nodes, 0 and m - 1 among them: a row from each to the next
    """
    length, rows = int(np.diff(cuts).max()), len(cuts) - 1
    at = cuts[:-1] + np.arange(1, length + 1)[:, None]
    past = at > cuts[1:]  # behind the end of a row its last node is repeated, at no cost
    at = np.minimum(at, cuts[1:])
    total = (cost + price).T[at]
    total[past] = np.inf
    total[past, 0] = 0.0
    total = np.ascontiguousarray(total.transpose(0, 2, 1)[:, ::-1])  # longest chord first
    best = np.full((REACH + length, rows), np.inf)
    best[REACH - 1] = 0.0
    came = np.empty((length, rows), dtype=np.int64)
    for place in range(length):
        reached = best[place : place + REACH] + total[place]
        came[place] = reached.argmin(axis=0)
        best[place + REACH] = reached.min(axis=0)
    return _nodes(REACH - came, at, len(price))


def _nodes(span: np.ndarray, at: np.ndarray, m: int) -> np.ndarray:
    """From the last place of each row back along the chords of `span`, shape (places, rows), bool, shape (m,)."""
    row = np.arange(span.shape[1])
    place = np.full(len(row), len(span) - 1)
    is_node = np.zeros(m, dtype=bool)
    is_node[0] = True
    while len(row):
        is_node[at[place, row]] = True
        place = place - span[place, row]
        row, place = row[place >= 0], place[place >= 0]
    return is_node
