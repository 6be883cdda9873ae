"""What was reproduced, as text for people, as Markdown for a page and as figures for scripts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from fbfcli.papers.item import DIFFERS, HOLDS, NOT_REPRODUCIBLE, Item, Result, Value


@dataclass(frozen=True)
class Reproduced:
    """One item that was recomputed.

    seconds : float        wall time
    picture : str | None   file of its figure
    """

    item: Item
    result: Result
    seconds: float
    picture: str | None


def differing(done: Sequence[Reproduced]) -> int:
    """How many rows came out wrong."""
    return sum(row.verdict == DIFFERS for each in done for row in each.result.rows)


def as_line(item: Item) -> str:
    """An item in the list of what there is."""
    return f"{item.name:<28} {'quick' if item.quick else '':<6} {item.title} ({item.paper}, {item.equations})"


def as_text(done: Reproduced) -> str:
    """One item with its rows, columns aligned."""
    item = done.item
    lines = [f"{item.name}: {item.title} ({item.paper}, {item.equations}), {done.seconds:.1f} s"]
    table = [("", "paper", "ours", "held to", "")]
    table += [
        (
            row.verdict,
            _shown(row.paper),
            _shown(row.ours),
            row.tolerance,
            row.what + (f" ({row.note})" if row.note else ""),
        )
        for row in done.result.rows
    ]
    widths = [max(map(len, column)) for column in list(zip(*table, strict=True))[:-1]]
    lines += ["  " + "  ".join([*map(str.ljust, row, widths), row[-1]]).rstrip() for row in table]
    if done.picture:
        lines.append(f"  {done.picture}: {done.result.caption}")
    return "\n".join(lines)


def as_markdown(done: Sequence[Reproduced]) -> str:
    """A page's tables: the rows that were compared, then those that do not reproduce, with the reason."""
    lines = []
    for each in done:
        item = each.item
        lines += [f"### `{item.name}`", "", f"{item.title} ({item.paper}, {item.equations}); {each.seconds:.1f} s.", ""]
        lines += ["| | paper | ours | held to | verdict |", "|---|---|---|---|---|"]
        lines += [
            f"| {_cell(row.what)}{f'<br>*{_cell(row.note)}*' if row.note else ''} | {_cell(_shown(row.paper))} "
            f"| {_cell(_shown(row.ours))} | {_cell(row.tolerance)} | {row.verdict} |"
            for row in each.result.rows
        ]
        lines.append("")
    return "\n".join(lines)


def as_figures(done: Sequence[Reproduced]) -> dict[str, object]:
    """For --json."""
    return {
        "items": [
            _described(each.item)
            | {
                "seconds": round(each.seconds, 3),
                "picture": each.picture,
                "caption": each.result.caption,
                "rows": [asdict(row) for row in each.result.rows],
            }
            for each in done
        ]
    } | dict(counted(done))


def as_catalogue(items: Sequence[Item]) -> dict[str, object]:
    """The list of what there is, for --json."""
    return {"items": [_described(item) for item in items]}


def _described(item: Item) -> dict[str, object]:
    return {
        "name": item.name,
        "title": item.title,
        "paper": item.paper,
        "equations": item.equations,
        "quick": item.quick,
    }


def counted(done: Sequence[Reproduced]) -> dict[str, int]:
    """Rows per verdict."""
    verdicts = [row.verdict for each in done for row in each.result.rows]
    return {verdict: verdicts.count(verdict) for verdict in (HOLDS, DIFFERS, NOT_REPRODUCIBLE)}


def _shown(value: Value) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:.6g}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
