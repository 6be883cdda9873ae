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

from dataclasses import dataclass

import numpy as np

REACH = 8  # candidates that a chord may span
ROW = 128  # candidates between nodes that are set: some 0.4 s


@dataclass(frozen=True)
class _Sums:
    """Sums over the samples between neighbouring candidates, shape (m - 1,).

    k counts samples from the first of the two candidates, v is the command along one axis less its value there.
    """

    v: np.ndarray
    vv: np.ndarray
    kv: np.ndarray

    @classmethod
    def of(cls, u: np.ndarray, at: np.ndarray) -> _Sums:
        """u : ndarray, shape (n,)   command along one axis;   at : ndarray of int, shape (m,)   candidates"""
        first, length = at[:-1], np.diff(at)
        v = u[at[0] : at[-1]] - np.repeat(u[first], length)
        k = np.arange(at[0], at[-1]) - np.repeat(first, length)
        rows = first - at[0]
        return cls(*(np.add.reduceat(samples, rows) for samples in (v, v * v, k * v)))


def chord_costs(u: np.ndarray, at: np.ndarray) -> np.ndarray:
    """c_ij for chords that span 1 to REACH candidates, shape (REACH, m): row w - 1 column j is that from j - w to j.

    u  : ndarray, shape (n, 2)      command [mm]
    at : ndarray of int, shape (m,) candidates

    With v and k counted from the chord's first sample and s its slope: sum (v - s k)^2 = Vv - 2 s Kv + s^2 Kk.
    """
    m = len(at)
    cost = np.full((REACH, m), np.inf)
    cost[:, 1:] = 0.0
    length = np.diff(at).astype(float)
    for axis in range(2):
        own, value = _Sums.of(u[:, axis], at), u[at, axis]
        Vv, Kv = np.zeros(m - 1), np.zeros(m - 1)
        for w in range(min(REACH, m - 1)):
            here = slice(w, None)  # the w-th interval of the chord that begins w candidates before it
            n, first = length[here], slice(None, m - 1 - w)
            dv, dk = value[w : m - 1] - value[first], (at[w : m - 1] - at[first]).astype(float)
            Vv, Kv = Vv[: m - 1 - w], Kv[: m - 1 - w]
            Kv = Kv + own.kv[here] + dk * own.v[here] + dv * (n * (0.5 * (n - 1.0) + dk))
            Vv = Vv + own.vv[here] + dv * (2.0 * own.v[here] + n * dv)
            span = (at[w + 1 :] - at[first]).astype(float)
            s = (value[w + 1 :] - value[first]) / span
            Kk = (span - 1.0) * span * (2.0 * span - 1.0) / 6.0
            cost[w, w + 1 :] += Vv + s * (s * Kk - 2.0 * Kv)
    for w in range(REACH):
        cost[w, : w + 1] = np.inf
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
