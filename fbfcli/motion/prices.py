"""Nodes where a firmware takes fewer or no shorter segments than the tolerance asks for: each segment has its price.

A firmware that takes `max_rate` segments per second and holds a few in its queue takes BURST + max_rate D of them in
any time D. The cheapest polyline (`chords`) pays a price for each segment; where it spends more than is taken, the
price is raised, so that corners are paid for by the straight lines near them. n chords of a stretch of curve leave an
error of about n^-4, one more saves n^-5: the price of n segments.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from fbfcli.motion.budget import BURST, Budget
from fbfcli.motion.chords import REACH, cheapest, chord_costs, even_cuts

LOWEST = 2.0  # tolerances squared: the price at which chords keep the tolerance
ROUNDS = 3  # of prices: a fourth makes the error a hundredth smaller
POWER = 4.0  # of spent over taken, by which a price follows: less than the law, so that it does not swing
BIN = 2.0  # segments that the firmware takes in the time for which one price holds
WINDOWS = (4, 8, 16, 32, 64, 128)  # bins over which segments are counted
LOST = 1e4  # price of a segment that the firmware would lose, of one that passes by a sample that should be a node,
PASSED = 10.0  # in mm^2: more than any error


def affordable(
    u: np.ndarray, at: np.ndarray, over: np.ndarray, is_end: np.ndarray, is_fixed: np.ndarray, dt: float, budget: Budget
) -> np.ndarray:
    """Those of the candidates `at`, shape (m,), that the firmware can have as nodes, increasing.

    u                : ndarray, shape (n, 2)          command [mm]
    over             : ndarray, shape (k,)            from `overspent`, of the segments that the tolerance asks for
    is_end, is_fixed : ndarray of bool, shape (n,)    must be nodes; should be
    """
    cost = chord_costs(u, at)
    _forbid(cost, u, at, is_end, is_fixed, dt, budget)
    time = bin_of(at, dt, budget)
    lowest = LOWEST * budget.tolerance**2
    price = lowest * np.maximum(over, 1.0) ** POWER
    is_node = np.ones(len(at), dtype=bool)
    for turn in range(ROUNDS):
        is_node = cheapest(cost, price[time], even_cuts(is_node, 0.5 * (turn % 2)))
        spent = np.bincount(time[is_node], minlength=len(price))
        price = np.maximum(price * overspent(spent) ** POWER, lowest)
    return at[is_node]


def bin_of(samples: np.ndarray, dt: float, budget: Budget) -> np.ndarray:
    """The bin of time, one price each, that each sample is in."""
    return (samples * (dt * budget.max_rate / BIN)).astype(np.int64)


def _forbid(
    cost: np.ndarray, u: np.ndarray, at: np.ndarray, is_end: np.ndarray, is_fixed: np.ndarray, dt: float, budget: Budget
) -> None:
    """Make chords dear that the firmware would lose or that pass by a fixed sample; none passes by an end."""
    m = len(at)
    order = np.arange(m)
    last_end, last_fixed = (np.maximum.accumulate(np.where(flag[at], order, 0)) for flag in (is_end, is_fixed))
    x, y = u[at, 0], u[at, 1]
    gap = np.zeros(m, dtype=bool)  # from the end of a stretch to the beginning of the next: not a segment
    gap[1:] = is_end[at[1:]] & is_end[at[:-1]] & (np.diff(at) == 1)
    for w in range(1, min(REACH, m - 1) + 1):
        row, begin = cost[w - 1, w:], order[: m - w]
        step = np.maximum(np.abs(x[w:] - x[:-w]), np.abs(y[w:] - y[:-w]))
        lost = budget.is_short(step, dt * (at[w:] - at[:-w]))
        if w == 1:
            lost &= ~gap[1:]
        row[lost] += LOST
        row[last_fixed[w - 1 : -1] > begin] += PASSED
        row[last_end[w - 1 : -1] > begin] = np.inf


def overspent(spent: np.ndarray) -> np.ndarray:
    """Segments in each bin (n,) over those that the firmware takes, in the window around it where that is largest."""
    most = np.zeros(len(spent))
    for window in WINDOWS:
        share = uniform_filter1d(spent.astype(float), window, mode="nearest") / (BIN + BURST / window)
        np.maximum(most, maximum_filter1d(share, window), out=most)
    return most
