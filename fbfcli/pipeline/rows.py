"""Figures for people: names and values, and columns."""

from __future__ import annotations

from collections.abc import Sequence

GAP = "  "


def row(name: str, value: str) -> str:
    """One name and its value; without a name the value goes on from the row before."""
    return f"{name + ':' if name else '':15s}{value}"


def told(rows: Sequence[tuple[str, str]], warnings: Sequence[str] = ()) -> str:
    """Names and values in two columns, and warnings under them."""
    return "\n".join([*(row(*each) for each in rows), *(f"warning: {warning}" for warning in warnings)])


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Rows of as many cells each: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for first, *others in rows:
        cells = [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        lines.append(GAP.join([first.ljust(widths[0]), *cells]))
    return "\n".join(lines)
