"""Tables of a page of docs/ that a benchmark writes: between two marks, one of which names the command."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

END = "<!-- end of table -->"


def options(doc: str | None, page: Path) -> argparse.ArgumentParser:
    """Of a benchmark with this docstring: --write."""
    parser = argparse.ArgumentParser(description=(doc or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"put what is found into docs/{page.name}")
    return parser


def program(doc: str | None, page: Path, command: str, tables: Callable[[], str]) -> None:
    """A benchmark without other options: print its tables, and put them into the page where that is asked for."""
    wanted = options(doc, page).parse_args()
    found = tables()
    print(found)
    if wanted.write:
        put(page, command, found)


def put(page: Path, command: str, tables: str) -> None:
    """New tables between <!-- table: command --> and the next end. Raises ValueError where a mark is missing."""
    begin = f"<!-- table: {command} -->"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, mark, after = rest.partition(END)
    if not mark:
        raise ValueError(f"{page}: needs the lines {begin} and {END}")
    page.write_text(f"{before}{begin}\n{tables}\n{END}{after}", encoding="utf-8")
