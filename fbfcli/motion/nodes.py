"""Nodes: the few samples at which the segments that stand for a command meet.

Legend: u command, sampled every dt; k sample; node = sample at which a segment ends.
A chord of length T on a curve of acceleration a is off by a T^2 / 8, so break points that equidistribute
sqrt(|u''| / (8 tolerance)) keep every chord within the tolerance with the fewest segments (de Boor, A Practical Guide
to Splines, ch. XII). Where the firmware takes fewer, or none as short, they are chosen by what they cost (`prices`).
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from fbfcli.motion.budget import BURST, Budget
from fbfcli.motion.chords import REACH
from fbfcli.motion.polyline import Polyline
from fbfcli.motion.prices import affordable, bin_of, overspent

MIN_RATE = 4.0  # segments per second of a straight line at constant speed: E, fans and pauses stay near their time
FINER = 1.5  # candidates for a node: with 3 the error is a twentieth smaller
MORE = 5.0  # where the firmware takes far fewer: a chord may be half as long again as the mean one
REFINEMENTS = 4  # passes that halve what a velocity step left outside the tolerance


def break_points(u: np.ndarray, ends: np.ndarray, forced: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """Samples at which segments begin and end, shape (m,), increasing.

    u      : ndarray, shape (n, 2)   command [mm]
    ends   : ndarray of int          first and last sample of each stretch, 2 per stretch, increasing
    forced : ndarray of int          samples inside stretches that should be nodes, where the firmware can have them
    """
    is_end = np.zeros(len(u), dtype=bool)
    is_end[ends] = True
    is_fixed = is_end.copy()
    is_fixed[forced] = True
    rate = _wanted(u, dt, budget)
    if budget.has_shortest or (_mean(rate, dt, budget) > budget.max_rate).any():
        over = overspent(np.bincount(bin_of(np.arange(len(u)), dt, budget), rate * dt))
        candidates = _candidates(u, rate, over, is_fixed, dt, budget)
        nodes = affordable(u, candidates, over, is_end, is_fixed, dt, budget)
        return _merge_short(u, nodes, is_end[nodes], budget, dt)
    is_node = is_fixed | _equidistribute(np.cumsum(rate) * dt, np.flatnonzero(is_fixed))
    for _ in range(REFINEMENTS):
        worst = _outside(u, np.flatnonzero(is_node), budget.tolerance)
        if not len(worst):
            break
        is_node[worst] = True
    return np.flatnonzero(is_node)


def thinned(wanted: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """The first of the wanted samples (sorted) in each of the shortest times that the firmware's rate allows."""
    slot = (wanted * (dt * budget.max_rate)).astype(np.int64)
    return wanted[np.diff(slot, prepend=-1) != 0]


def _wanted(u: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """Segments per second that keep the tolerance, sqrt(|u''| / 8 tolerance), shape (n,)."""
    bend_x, bend_y = np.diff(u[:, 0], 2), np.diff(u[:, 1], 2)
    bend = np.sqrt(bend_x * bend_x + bend_y * bend_y)
    rate = np.empty(len(u))
    rate[1:-1] = np.sqrt(bend * (1.0 / (8.0 * budget.tolerance * dt * dt)))
    rate[:1], rate[-1:] = rate[1:2], rate[-2:-1]
    return np.clip(rate, MIN_RATE, 1.0 / dt, out=rate)


def _mean(rate: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """Mean rate over the time in which the firmware takes BURST segments, shape (n,)."""
    return uniform_filter1d(rate, max(1, round(BURST / (budget.max_rate * dt))), mode="nearest")


def _candidates(
    u: np.ndarray, rate: np.ndarray, over: np.ndarray, is_fixed: np.ndarray, dt: float, budget: Budget
) -> np.ndarray:
    """FINER samples for each node that the tolerance asks for, or MORE for each that the firmware takes, shape (m,)."""
    rate = rate * np.minimum(FINER, MORE / over)[bin_of(np.arange(len(u)), dt, budget)]
    if budget.min_length > 0:
        speed = np.maximum(np.abs(np.diff(u[:, 0])), np.abs(np.diff(u[:, 1]))) * (FINER / (budget.min_length * dt))
        np.minimum(rate[1:], speed, out=rate[1:])
    np.clip(rate, MIN_RATE * REACH, 1.0 / dt, out=rate)
    return np.flatnonzero(is_fixed | _equidistribute(np.cumsum(rate) * dt, np.flatnonzero(is_fixed)))


def _equidistribute(share: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Where the cumulative share, stretched to a whole number between fixed samples, passes an integer, bool, (n,)."""
    wanted = share[fixed[1:]] - share[fixed[:-1]]
    pieces = np.maximum(np.ceil(wanted - 1e-9), 1.0)
    base = np.concatenate([[0.0], np.cumsum(pieces)])
    length = np.diff(fixed)
    first = fixed[0]
    local = share[first : fixed[-1]] - np.repeat(share[fixed[:-1]], length)
    local *= np.repeat(pieces / np.maximum(wanted, 1e-300), length)
    local += np.repeat(base[:-1], length)
    turns = np.floor(local, out=local)
    passes = np.zeros(len(share), dtype=bool)
    np.not_equal(turns[1:], turns[:-1], out=passes[first + 1 : fixed[-1]])
    return passes


def _outside(u: np.ndarray, nodes: np.ndarray, tolerance: float) -> np.ndarray:
    """The worst sample of each chord that misses the tolerance by half and may still be divided."""
    first, last = nodes[0], nodes[-1] + 1
    chords = Polyline(nodes - first, np.zeros(len(nodes), dtype=bool))
    error = np.abs(chords.curve(u[nodes, 0]) - u[first:last, 0])
    np.maximum(error, np.abs(chords.curve(u[nodes, 1]) - u[first:last, 1]), out=error)
    peak = np.maximum.reduceat(error[:-1], nodes[:-1] - first)
    bad = np.flatnonzero((peak > 1.5 * tolerance) & (np.diff(nodes) > 1))
    return np.array(
        [nodes[i] + int(np.argmax(error[nodes[i] - first : nodes[i + 1] - first])) for i in bad], dtype=nodes.dtype
    )


def _merge_short(u: np.ndarray, nodes: np.ndarray, pinned: np.ndarray, budget: Budget, dt: float) -> np.ndarray:
    """Nodes without those that end a segment too short along both axes, or too slow; pinned ones stay.

    A short segment gives up its end, or its beginning where the end is pinned; of neighbours that would go, every other
    one goes first: the longer segments may be long enough.
    """
    while True:
        step = np.maximum(np.abs(np.diff(u[nodes, 0])), np.abs(np.diff(u[nodes, 1])))
        short = budget.is_short(step, dt * np.diff(nodes))
        drop = np.zeros(len(nodes), dtype=bool)
        drop[1:] = short
        drop[:-1] |= short & pinned[1:]
        drop &= ~pinned
        going = np.flatnonzero(drop)
        if not len(going):
            return nodes
        new = np.diff(going, prepend=-2) > 1
        place = np.arange(len(going)) - np.flatnonzero(new)[np.cumsum(new) - 1]
        drop[going[place % 2 == 1]] = False
        nodes, pinned = nodes[~drop], pinned[~drop]
