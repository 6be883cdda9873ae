"""Nodes: the few samples at which the segments that stand for a command meet.

Legend: u command, sampled every dt; k sample; node = sample at which a segment ends.
A chord of length T on a curve of acceleration a is off by a T^2 / 8, so break points that equidistribute
sqrt(|u''| / (8 tolerance)) keep every chord within the tolerance with the fewest segments (de Boor, A Practical Guide
to Splines, ch. XII).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from fbfcli.motion.polyline import Polyline

BURST = 8.0  # segments: half of the smallest queue (16), so that corners may have more and straight lines fewer
ALONG = 0.3  # worth of an error along the path against one across it, where not both can be had
FITTED = 4.0  # tolerances that a fit may move nodes towards each other
MIN_RATE = 4.0  # segments per second of a straight line at constant speed: E, fans and pauses stay near their time
ROOM = 1.1  # segments are planned this much longer than the shortest that the firmware keeps: few must be merged
REFINEMENTS = 4  # passes that halve what a velocity step left outside the tolerance


@dataclass(frozen=True)
class Budget:
    """What segments may be.

    tolerance  : largest distance of a chord from the command [mm]
    max_rate   : segments per second that the firmware takes on average over BURST of them [1/s]
    min_length : shorter segments are dropped by the firmware [mm]
    min_speed  : slower ones are sped up by it [mm/s]
    """

    tolerance: float
    max_rate: float
    min_length: float = 0.0
    min_speed: float = 0.0


def break_points(u: np.ndarray, ends: np.ndarray, forced: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """Samples at which segments begin and end, shape (m,), increasing.

    u      : ndarray, shape (n, 2)   command [mm]
    ends   : ndarray of int          first and last sample of each stretch, 2 per stretch, increasing
    forced : ndarray of int          samples inside stretches that should be nodes, where the firmware can have them
    """
    is_fixed = np.zeros(len(u), dtype=bool)
    is_fixed[ends] = is_fixed[forced] = True
    rate, full = _rate(u, dt, budget)
    share = np.cumsum(rate) * dt
    is_node = _equidistribute(share, np.flatnonzero(is_fixed))
    is_node |= is_fixed
    for _ in range(REFINEMENTS):
        worst = _outside(u, np.flatnonzero(is_node), budget.tolerance, full)
        if not len(worst):
            break
        is_node[worst] = True
    nodes = np.flatnonzero(is_node)
    if budget.min_length > 0 or budget.min_speed > 0:
        is_end = np.zeros(len(u), dtype=bool)
        is_end[ends] = True
        nodes = _merge_short(u, nodes, is_end[nodes], budget, dt)
    return nodes


def thinned(wanted: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """The first of the wanted samples (sorted) in each of the shortest times that the firmware's rate allows."""
    slot = (wanted * (dt * budget.max_rate)).astype(np.int64)
    return wanted[np.diff(slot, prepend=-1) != 0]


def _rate(u: np.ndarray, dt: float, budget: Budget) -> tuple[np.ndarray, np.ndarray]:
    """Segments per second at each sample, shape (n,), and where the firmware takes no more, bool, shape (n,)."""
    step_x, step_y = np.diff(u[:, 0]), np.diff(u[:, 1])
    bend_x, bend_y = np.diff(step_x), np.diff(step_y)
    most = np.full(len(u), 1.0 / dt)
    if budget.min_length > 0:
        speed = np.maximum(np.abs(step_x), np.abs(step_y)) / dt
        np.minimum(most[1:], np.maximum(speed / (ROOM * budget.min_length), MIN_RATE), out=most[1:])
    rate = _wanted(np.sqrt(bend_x * bend_x + bend_y * bend_y), most, dt, budget)
    mean = _mean(rate, dt, budget)
    full = mean > budget.max_rate
    if full.any():  # what bends the path counts before what only changes the speed along it
        speed = np.sqrt(step_x * step_x + step_y * step_y)[1:] + 1e-300
        across = np.abs(step_x[1:] * bend_y - step_y[1:] * bend_x) / speed
        along = np.abs(step_x[1:] * bend_x + step_y[1:] * bend_y) / speed
        rate = np.where(full, _wanted(across + ALONG * along, most, dt, budget), rate)
        rate *= np.minimum(1.0, budget.max_rate / _mean(rate, dt, budget))
    return rate, full


def _wanted(bend: np.ndarray, most: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """sqrt(|u''| / 8 tolerance) for second differences `bend` (n - 2,) [mm], within bounds, shape (n,)."""
    rate = np.empty(len(bend) + 2)
    rate[1:-1] = np.sqrt(bend * (1.0 / (8.0 * budget.tolerance * dt * dt)))
    rate[:1], rate[-1:] = rate[1:2], rate[-2:-1]
    return np.clip(rate, MIN_RATE, most, out=rate)


def _mean(rate: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """Mean rate over the time in which the firmware takes BURST segments, shape (n,)."""
    return uniform_filter1d(rate, max(1, round(BURST / (budget.max_rate * dt))), mode="nearest")


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


def _outside(u: np.ndarray, nodes: np.ndarray, tolerance: float, full: np.ndarray) -> np.ndarray:
    """The worst sample of each chord that misses the tolerance by half and may still be divided."""
    first, last = nodes[0], nodes[-1] + 1
    chords = Polyline(nodes - first, np.zeros(len(nodes), dtype=bool))
    error = np.abs(chords.curve(u[nodes, 0]) - u[first:last, 0])
    np.maximum(error, np.abs(chords.curve(u[nodes, 1]) - u[first:last, 1]), out=error)
    error[full[first:last]] = 0.0
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
        short = step < budget.min_length
        if budget.min_speed > 0:
            short |= step - FITTED * budget.tolerance < budget.min_speed * dt * np.diff(nodes)
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
