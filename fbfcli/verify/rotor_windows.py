"""Stretches of a motor's course that are integrated: what is needed, with some time before and after."""

from __future__ import annotations

import numpy as np

from fbfcli.verify.rotor import Course, joined

LEAD_S, TAIL_S = 0.05, 0.03  # s: the rotor starts at its equilibrium before, and may swing after
LONGEST_S = 4.0  # s: a longer window is cut, the rotor starting anew


class Windows:
    """Cuts windows out of a course that arrives in pieces; where it is cut into pieces makes no difference."""

    def __init__(self, dt: float):
        self._lead, self._tail = round(LEAD_S / dt), round(TAIL_S / dt)
        self._longest = round(LONGEST_S / dt)
        self._course: Course | None = None  # samples that a window may still begin or go on in
        self._needed = np.zeros(0, dtype=bool)

    def add(self, course: Course, needed: np.ndarray) -> list[Course]:
        """Windows that are complete with more of the course; needed : ndarray of bool, shape (n,)."""
        self._course = joined([self._course, course]) if self._course else course
        self._needed = np.concatenate([self._needed, needed])
        return self._taken(last=False)

    def finish(self) -> list[Course]:
        """The windows that the end of the course completes."""
        return self._taken(last=True) if self._course else []

    def _taken(self, last: bool) -> list[Course]:
        course, needed = self._course, self._needed
        assert course is not None
        n, floor, windows = len(course), 0, []
        apart = self._lead + self._tail
        while len(at := floor + np.flatnonzero(needed[floor:])):
            gap = np.flatnonzero(np.diff(at) > apart)
            end = int(at[gap[0]] if len(gap) else at[-1])
            start = max(int(at[0]) - self._lead, floor)
            if end + self._tail + 1 > start + self._longest:
                stop = start + self._longest
                if stop < n:
                    needed[stop] = True  # it goes on there
                elif not last:
                    break
            elif last or end + apart < n:
                stop = end + self._tail + 1
            else:
                break
            windows.append(course[start : min(stop, n)])
            floor = min(stop, n)
        keep = max(start if len(at) else n - self._lead, floor)
        self._course, self._needed = course[keep:], needed[keep:].copy()
        return windows
