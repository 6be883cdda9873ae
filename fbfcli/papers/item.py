"""One table or figure of a paper: how it is recomputed, and how its numbers compare with what is printed.

A row's verdict is `holds` or `differs`, or `not reproducible` where the paper leaves out what the number rests on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HOLDS, DIFFERS, NOT_REPRODUCIBLE = "holds", "differs", "not reproducible"

Value = str | float | None
Progress = Callable[[float], None]  # told the fraction that is done, 0..1


@dataclass(frozen=True)
class Row:
    """One number of a paper and ours.

    what      : str    the quantity, with its unit
    paper     : Value  as printed; None where the paper draws it without a number
    ours      : Value  as computed here; None where it cannot be
    tolerance : str    what ours is held to: "0.7349 ± 0.001", "at most 1e-9", "order of magnitude"
    verdict   : str    HOLDS, DIFFERS or NOT_REPRODUCIBLE
    note      : str    why it differs or does not reproduce; the spread of a mean
    """

    what: str
    paper: Value
    ours: Value
    tolerance: str
    verdict: str
    note: str = ""


@dataclass(frozen=True)
class Result:
    """What came out.

    rows    : tuple of Row
    figure  : draws on an empty figure, or None where the item is a table without a drawing
    caption : str, says what is drawn and by which equations
    """

    rows: tuple[Row, ...]
    figure: Callable[[Figure], None] | None = None
    caption: str = ""


@dataclass(frozen=True)
class Item:
    """Something that `fbf reproduce` can recompute.

    name      : str   what people type: "duan-2015-table-2"
    title     : str   one line
    paper     : str   the paper's short name: "Duan 2015"
    equations : str   the equations it exercises: "Eq. 37, 38"
    quick     : bool  whether it belongs to the minute that is spent on every change
    compute   : from (seeds, progress) to Result; seeds: how many random draws a mean is taken over
    """

    name: str
    title: str
    paper: str
    equations: str
    quick: bool
    compute: Callable[[int, Progress], Result]


def near(what: str, paper: Value, ours: float, expected: float, tolerance: float, note: str = "") -> Row:
    """A number that must be `expected` within an absolute tolerance."""
    return judged(abs(ours - expected) <= tolerance, what, paper, ours, f"{expected:.10g} ± {tolerance:.2g}", note)


def close(what: str, paper: Value, ours: float, expected: float, relative: float, note: str = "") -> Row:
    """A number that must be `expected` within a relative tolerance."""
    agrees = abs(ours - expected) <= relative * abs(expected)
    return judged(agrees, what, paper, ours, f"{expected:.10g} ± {relative:.2g} relative", note)


def between(what: str, paper: Value, ours: float, low: float, high: float, note: str = "") -> Row:
    """A number that must lie in a stated spread."""
    return judged(low <= ours <= high, what, paper, ours, f"{low:.6g} .. {high:.6g}", note)


def judged(agrees: bool, what: str, paper: Value, ours: Value, tolerance: str, note: str = "") -> Row:
    """A claim that is either so or not: an ordering, a count, a sign."""
    return Row(what, paper, ours, tolerance, HOLDS if agrees else DIFFERS, note)


def not_reproducible(what: str, paper: Value, why: str, ours: Value = None) -> Row:
    """A number of the paper that rests on what the paper does not give, with the reason."""
    return Row(what, paper, ours, "none", NOT_REPRODUCIBLE, why)
