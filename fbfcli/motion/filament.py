"""Filament pushed in step with the nozzle: E per mm of the way it really goes, not of the way it should go.

A nozzle that is ahead of or behind the desired motion draws a bead that is too thin or too thick if E keeps that
motion's time. What is known of the vibration tells its speed; E then follows it.
"""

from __future__ import annotations

import numpy as np

EPS_MM = 1e-9  # of filament in one sample: less is none


def following(e: np.ndarray, path: np.ndarray, nozzle: np.ndarray, begin: np.ndarray) -> np.ndarray:
    """E that gives each mm of the nozzle's way what each mm of the path was given, shape (n,) [mm].

    e      : ndarray, shape (n,)          desired E [mm]
    path   : ndarray, shape (n, 2)        desired X Y [mm]
    nozzle : ndarray, shape (n, 2)        where the nozzle is expected [mm]
    begin  : ndarray of int, shape (s,)   samples at which stretches begin, the first of them 0

    Sections that push filament without a pause get exactly what they were to get; nothing else is changed, and where
    the desired E rises it never falls.
    """
    push = np.diff(e, prepend=e[:1])
    push[begin] = 0.0  # from one stretch to the next
    way, went = (np.hypot(*np.diff(each, axis=0, prepend=each[:1]).T) for each in (path, nozzle))
    printing = (push > EPS_MM) & (way > EPS_MM)
    first = np.flatnonzero(printing & ~np.append(False, printing[:-1]))
    if not len(first):
        return e.copy()
    given = np.divide(push * went, way, out=np.zeros_like(push), where=printing)
    wanted = np.where(printing, push, 0.0)
    section = np.cumsum(np.isin(np.arange(len(e)), first)) - 1
    total, total_given = np.add.reduceat(wanted, first), np.add.reduceat(given, first)
    share = np.divide(total, total_given, out=np.zeros(len(first)), where=total_given > EPS_MM)
    change = np.where(printing & (share[section] > 0.0), given * share[section] - push, 0.0)
    return e + _exact_ends(np.cumsum(change), printing)


def _exact_ends(change: np.ndarray, printing: np.ndarray) -> np.ndarray:
    """The sum of changes without the rounding that is left where nothing is printed."""
    ends = printing & ~np.append(printing[1:], False)
    return np.where(printing & ~ends, change, 0.0)
