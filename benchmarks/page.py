"""Tables of a page of docs/ that a benchmark writes: between two marks, one of which names the command."""

from __future__ import annotations

from pathlib import Path

END = "<!-- end of table -->"


def put(page: Path, command: str, tables: str) -> None:
    """New tables between <!-- table: command --> and the next end. Raises ValueError where a mark is missing."""
    begin = f"<!-- table: {command} -->"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, mark, after = rest.partition(END)
    if not mark:
        raise ValueError(f"{page}: needs the lines {begin} and {END}")
    page.write_text(f"{before}{begin}\n{tables}\n{END}{after}", encoding="utf-8")
