"""Fewer points of a curve: the rest lie within a tolerance of the polyline through those that stay.

Douglas and Peucker's subdivision (Cartographica 10, 1973), all chords of a level at once.
"""

from __future__ import annotations

import numpy as np


def thinned(x: np.ndarray, seeds: np.ndarray, tolerance: float) -> np.ndarray:
    """Rows of x that stay, in order: ndarray of int.

    x         : ndarray, shape (n, d)      a curve
    seeds     : ndarray of int             rows that stay in any case; the ends always do
    tolerance : float                      every row is this near to the chord between its neighbours that stay
    """
    stays = np.zeros(len(x), dtype=bool)
    stays[seeds] = stays[:1] = stays[-1:] = True
    kept = np.flatnonzero(stays)
    first, last = kept[:-1], kept[1:]  # chords that were not looked at yet
    columns = [np.ascontiguousarray(column) for column in x.T]
    while len(first := first[wide := last - first > 1]):
        last = last[wide]
        far, distance = _farthest(columns, first, last)
        split = distance > tolerance
        far = far[split]
        stays[far] = True
        first, last = np.concatenate([first[split], far]), np.concatenate([far, last[split]])
    return np.flatnonzero(stays)


def _farthest(columns: list[np.ndarray], first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the rows strictly between `first` and `last`, the one farthest from each chord, and how far, shape (k,)."""
    count = last - first - 1
    begin = np.cumsum(count) - count
    row = np.arange(count.sum()) + np.repeat(first + 1 - begin, count)
    spans = [x[last] - x[first] for x in columns]
    aways = [x[row] - np.repeat(x[first], count) for x in columns]
    squared = np.maximum(sum(span * span for span in spans), np.finfo(float).tiny)
    along = np.zeros(len(row))  # share of the chord at which each row's foot is
    for away, span in zip(aways, spans, strict=True):
        along += away * np.repeat(span / squared, count)
    np.clip(along, 0.0, 1.0, out=along)
    distance = np.zeros(len(row))
    for away, span in zip(aways, spans, strict=True):
        away -= along * np.repeat(span, count)
        distance += away * away
    most = np.maximum.reduceat(distance, begin)
    at = np.flatnonzero(distance == np.repeat(most, count))
    chord = np.searchsorted(begin, at, side="right") - 1
    at = at[np.diff(chord, prepend=-1) > 0]  # the first of equals
    return row[at], np.sqrt(most)
