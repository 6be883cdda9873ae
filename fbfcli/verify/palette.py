"""The colours of every picture of a print: told apart by people who see no red or green, and on a black and white copy.

Okabe and Ito, Color Universal Design (2008), for methods. Errors go from a light blue that nobody minds over orange to
a dark red.
"""

from __future__ import annotations

DESIRED = "#9aa0a6"
METHODS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#4d4d4d")  # before, after, and others
LIMIT = "#4d4d4d"
INK, FAINT, GRID = "#20262d", "#5f6b76", "#e3e7eb"

ERROR_STEPS = (10.0, 25.0, 50.0, 100.0, 200.0)  # um: from about 25 on a wall shows it
ERRORS = ("#c3d9ee", "#7fb2dd", "#3f7fc0", "#f4a582", "#d6604d", "#7f1d1d")  # up to each step, and beyond the last
