"""Look-ahead: the fastest corner speeds that the limits allow, as minimum-accumulations.

    w      squared speed v^2 at the n + 1 corners of n moves [mm^2/s^2]
    W      the most a corner allows
    D      2 a d, the most w can change along a move
    m, m'  the same as w and D with the acceleration a' of Klipper's minimum cruise ratio
    c      squared cruise speed of a move

w_i = min(W_i, w_{i-1} + D_{i-1}, w_{i+1} + D_i) is solved by w_i = min_j (W_j + |S_i - S_j|), S = cumsum(D): one
accumulated minimum of W - S forwards and one of W + S backwards. The cruise rule is that of Klipper's look-ahead queue
(klippy/toolhead.py, LookAheadQueue.flush).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.motion.junctions import Corners, corner_limits
from fbfcli.motion.moves import Moves

ROW = 128  # corners per accumulated sum: short enough that W - S + S keeps 12 digits of the largest W
SAME_W = 1e-9  # of the largest w: two w closer than this are limited by the same corner


@dataclass(frozen=True)
class Plan:
    """Speeds of n moves; w_end of a move is w_start of the next.

    d, accel                : ndarray, shape (n,)  distance [mm], acceleration [mm/s^2]
    w_start, w_cruise, w_end : ndarray, shape (n,)  squared speeds [mm^2/s^2]
    """

    d: np.ndarray
    accel: np.ndarray
    w_start: np.ndarray
    w_cruise: np.ndarray
    w_end: np.ndarray

    def __len__(self) -> int:
        return len(self.d)

    def __getitem__(self, part: slice) -> Plan:
        return Plan(self.d[part], self.accel[part], self.w_start[part], self.w_cruise[part], self.w_end[part])


def plan(corners: Corners, d: np.ndarray, w_first: float = 0.0, w_last: float = 0.0) -> Plan:
    """Plan n moves of length d, shape (n,), from w_first before the first to w_last after the last."""
    W = _corner_caps(corners, w_first, w_last)
    D = 2.0 * corners.accel * d
    w = reach(W, D)
    if corners.smooth is corners.accel:
        c = np.minimum(0.5 * (w[:-1] + w[1:] + D), corners.cruise)
    else:
        D_smooth = 2.0 * corners.smooth * d
        c = _smoothed_cruise(corners.cruise, w, D, reach(W, D_smooth), D_smooth)
    # the cruise speed caps both ends of its move, and is never below them (rounding)
    w[:-1] = np.minimum(w[:-1], c)
    w[1:] = np.minimum(w[1:], c)
    return Plan(d, corners.accel, w[:-1], c, w[1:])


def plan_block(moves: Moves, firmware: str, previous: Moves | None = None, w_entry: float = 0.0,
               last: bool = False) -> tuple[Plan, int]:
    """Plan as many leading moves as no later move can change; `last`: nothing follows, plan them all to rest.

    previous : the move before this block (one move), None at rest
    w_entry  : `w_end[-1]` of the part planned before [mm^2/s^2]
    Returns the plan of the first n_settled moves (possibly none) and n_settled. Carry `moves[n_settled:]` over to the
    next block; planning a file in blocks of any size gives the plan of the whole file.
    """
    corners = corner_limits(moves, firmware, previous)
    d = moves.distance
    if last:
        return plan(corners, d, w_entry, 0.0), len(moves)
    n_settled = settled(corners, d, w_entry)
    return plan(corners[:n_settled], d[:n_settled], w_entry, _entry_at(corners, n_settled)), n_settled


def settled(corners: Corners, d: np.ndarray, w_first: float = 0.0) -> int:
    """How many leading moves are planned the same whatever comes after the block.

    A corner is settled where even a stop at the end of the block would not lower it: m_i + S_i <= S_n, true for a
    prefix of corners because m + S never falls. The block is cut at the last settled corner that is as fast as the
    corner itself allows (m = w = W): from there on, w alone says all about the past, Klipper's peak speeds included.
    """
    if not len(d):
        return 0
    D_smooth = 2.0 * corners.smooth * d
    W = _corner_caps(corners, w_first, np.inf)
    m = reach(W, D_smooth)
    eps = SAME_W * _largest(W)
    to_end = np.cumsum(D_smooth[::-1])[::-1]
    cuttable = (m[1:-1] + eps <= to_end[1:]) & (m[1:-1] + eps >= W[1:-1])
    cuttable &= m[:-2] + D_smooth[:-1] > m[1:-1] + eps
    cuts = np.flatnonzero(cuttable)
    return int(cuts[-1]) + 1 if len(cuts) else 0


def reach(W: np.ndarray, D: np.ndarray) -> np.ndarray:
    """min_j (W_j + sum of D between corners i and j), shape (n + 1,), for W of shape (n + 1,), D of shape (n,)."""
    D = np.minimum(D, _largest(W))  # a move that can do any change needs no more; keeps S short of cancellation
    forwards = _reach_forwards(W, D)
    backwards = _reach_forwards(forwards[::-1], D[::-1])
    return backwards[::-1]


def _reach_forwards(W: np.ndarray, D: np.ndarray) -> np.ndarray:
    """w_i = min(W_i, w_{i-1} + D_{i-1}) by rows of accumulated minima of W - S."""
    n = len(W)
    rows = -(-n // ROW)
    S, w = np.zeros((rows, ROW)), np.full((rows, ROW), np.inf)
    S.ravel()[1:n] = D
    w.ravel()[:n] = W
    np.cumsum(S, axis=1, out=S)
    w -= S
    np.minimum.accumulate(w, axis=1, out=w)
    w += S
    carry = np.empty((rows, 1))
    w_before = np.inf
    for row, (w_row, s_row) in enumerate(zip(w[:, -1].tolist(), S[:, -1].tolist(), strict=True)):
        carry[row] = w_before
        w_before = min(w_row, w_before + s_row)
    S += carry
    np.minimum(w, S, out=w)
    return np.minimum(w.ravel()[:n], W)


def _smoothed_cruise(cruise: np.ndarray, w: np.ndarray, D: np.ndarray, m: np.ndarray,
                     D_smooth: np.ndarray) -> np.ndarray:
    """Klipper's cruise rule: no move cruises faster than the peak of the smoothed plan m around it.

    A move that both gains and loses m has its own peak; one that only gains shares the peak it leads to, one that only
    loses takes no more than the move before it.
    """
    n = len(D)
    eps = SAME_W * _largest(m)
    gains = m[1:] + D_smooth > m[:-1] + eps
    loses = m[:-1] + D_smooth > m[1:] + eps
    peak = np.where(gains, 0.5 * (m[:-1] + m[1:] + D_smooth), m[:-1])
    top = np.where(loses, np.arange(n), n)
    top = np.minimum.accumulate(top[::-1])[::-1]
    peak = np.append(peak, m[-1])[top]
    c = np.minimum(np.minimum(0.5 * (w[:-1] + w[1:] + D), cruise), peak)
    falling = np.flatnonzero(~gains)
    if len(falling):
        last_gain = np.maximum.accumulate(np.where(gains, np.arange(n), -1))[falling]
        c[falling] = np.where(last_gain < 0, w[falling], np.minimum(c[last_gain], w[falling]))
        while len(falling := falling[(falling > 0) & (c[falling - 1] < c[falling]) & ~gains[falling]]):
            c[falling] = c[falling - 1]
            falling = np.minimum(falling + 1, n - 1)
    return c


def _corner_caps(corners: Corners, w_first: float, w_last: float) -> np.ndarray:
    """The n + 1 corner limits W, with the given ends."""
    W = np.append(corners.entry, w_last)
    W[0] = w_first
    return W


def _entry_at(corners: Corners, n: int) -> float:
    return float(corners.entry[n]) if n < len(corners.entry) else 0.0


def _largest(W: np.ndarray) -> float:
    """The largest finite entry, 0 if there is none."""
    return float(np.max(W, initial=0.0, where=np.isfinite(W)))
