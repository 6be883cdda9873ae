"""`fbf reproduce`: the papers' tables and figures, recomputed and compared with what is printed."""

from __future__ import annotations

import os
import textwrap
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

import fbfcli
from fbfcli.cli.files import DASH, check_targets, reading, replacing, saying
from fbfcli.cli.lookup import find_printer
from fbfcli.cli.options import json_option, quiet_option
from fbfcli.cli.telling import fraction_bar, named, tell_json
from fbfcli.errors import FbfError

if TYPE_CHECKING:
    from fbfcli.papers.item import Item, Result
    from fbfcli.papers.listing import Reproduced

FOLDER = "reproduced"
STUDIED = "hictop_prusa_i3"  # the printer of Ramani 2018
SAMPLE = Path(fbfcli.__file__).parents[1] / "sample_gcode" / "star.gcode"
SIZE_IN = (8.0, 5.0)
DPI = 120
CAPTION_PT = 8
CHARACTERS_PER_IN = 18  # of a caption in that size


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "everything", is_flag=True, help="Reproduce every item.")
@click.option("--quick", is_flag=True, help="Reproduce the items that take seconds: a minute of CPU time together.")
@click.option("-o", "--output", default=FOLDER, show_default=True, metavar="FOLDER", help="Where figures go, as PNG.")
@click.option("--seeds", type=click.IntRange(1, 1000), default=20, show_default=True, help="Random draws of a mean.")
@click.option("--part", metavar="FILE", help="G-code for ramani-2018-table-1. [default: a sample of the source tree]")
@click.option("--markdown", "markdown_to", metavar="FILE", help="Write the tables as Markdown; - is standard output.")
@json_option
@quiet_option
def reproduce(
    names: tuple[str, ...],
    everything: bool,
    quick: bool,
    output: str,
    seeds: int,
    part: str | None,
    markdown_to: str | None,
    json_to: str | None,
    quiet: bool,
) -> None:
    """Recompute the papers' tables and figures, and say which numbers hold.

    Without a NAME, lists what can be reproduced. A NAME is an item or the beginning of several. Each row tells what the
    paper prints, what this program computes, what that is held to, and the verdict; rows that rest on hardware or on
    unpublished data say so. Leaves with 1 where a number differs.

    \b
    fbf reproduce                                        the list
    fbf reproduce ramani-2020-fig-4.3                    one item; its figure goes to reproduced/
    fbf reproduce duan-2015 -o figures                   everything of one paper
    fbf reproduce --quick --json - | jq '.items[].rows[] | select(.verdict == "differs")'
    """
    from fbfcli.papers.listing import as_catalogue, as_figures, as_line, as_markdown, as_text, counted, differing

    if sum((bool(names), everything, quick)) > 1:
        raise click.UsageError("take NAMEs, --quick or --all, not two of them")
    if json_to == DASH and markdown_to == DASH:
        raise click.UsageError("--json and --markdown both go to standard output: give one of them a file")
    _writable(output)
    check_targets([part] if part else [], json_to, markdown_to)
    items = _items(part)
    if not (names or everything or quick):
        if json_to:
            tell_json(json_to, as_catalogue(items))
        if json_to != DASH:
            click.echo("\n".join(map(as_line, items)))
        return
    chosen = items if everything else [item for item in items if item.quick] if quick else _named(names, items)
    taken = DASH in (json_to, markdown_to)  # standard output is for scripts then, and people read standard error
    done = []
    for item in chosen:
        done.append(_reproduced(item, seeds, Path(output), quiet))
        if not (quiet and taken):
            click.echo(as_text(done[-1]) + "\n", err=taken)
    if json_to:
        tell_json(json_to, as_figures(done))
    if markdown_to:
        with saying(markdown_to) as say:
            say(as_markdown(done))
    if not quiet:
        click.echo(", ".join(f"{count} {verdict}" for verdict, count in counted(done).items()), err=True)
    if count := differing(done):
        words = "number differs from what it is" if count == 1 else "numbers differ from what they are"
        raise FbfError(f"{count} {words} held to")


def _writable(folder: str) -> None:
    """Refuse before the work, not after it, what could not be written."""
    if Path(folder).exists() and not Path(folder).is_dir():
        raise FbfError(f"{folder}: is not a folder; figures go to one (-o)")
    there = next(each for each in (Path(folder).absolute(), *Path(folder).absolute().parents) if each.exists())
    if not os.access(there, os.W_OK):
        raise FbfError(f"{folder}: {there} cannot be written to; name another folder (-o)")


def _items(part: str | None) -> list[Item]:
    from fbfcli.papers import catalogue
    from fbfcli.pipeline import acceleration_study

    file = part or str(SAMPLE)
    study = acceleration_study.item(lambda: _text(file), lambda: find_printer(STUDIED))

    def compute(seeds: int, progress: Callable[[float], None]) -> Result:
        with named(file, STUDIED):
            return study.compute(seeds, progress)

    told = replace(study, compute=compute)
    return [*catalogue.items(), told] if part or SAMPLE.is_file() else [*catalogue.items()]


def _text(file: str) -> bytes:
    with reading(file) as source:
        return source.read()


def _named(names: Sequence[str], items: Sequence[Item]) -> list[Item]:
    """The items that are called so or begin so, in the catalogue's order."""
    for name in names:
        if not name or not any(item.name.startswith(name) for item in items):
            near = get_close_matches(name, [item.name for item in items], n=1)
            raise click.UsageError(f"nothing is called {name!r}" + (f"; did you mean {near[0]!r}?" if near else "")
                                   + " ('fbf reproduce' lists what there is)")  # fmt: skip
    return [item for item in items if any(item.name == name for name in names) or _begins(item, names, items)]


def _begins(item: Item, names: Sequence[str], items: Sequence[Item]) -> bool:
    """Whether a name that is nobody's own begins this item's."""
    owned = {other.name for other in items}
    return any(name not in owned and item.name.startswith(name) for name in names)


def _reproduced(item: Item, seeds: int, folder: Path, quiet: bool) -> Reproduced:
    from fbfcli.papers.listing import Reproduced

    began = perf_counter()
    with fraction_bar(item.name, quiet) as progress:
        result = item.compute(seeds, progress)
    seconds = perf_counter() - began
    return Reproduced(item, result, seconds, _draw(item.name, result, folder))


def _draw(name: str, result: Result, folder: Path) -> str | None:
    """The item's figure with its caption, as a PNG; its file."""
    if result.figure is None:
        return None
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE_IN, layout="constrained")
    result.figure(figure)
    width = int(figure.get_size_inches()[0] * CHARACTERS_PER_IN)
    figure.supxlabel(textwrap.fill(result.caption, width), x=0.01, ha="left", fontsize=CAPTION_PT)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.png"
    with replacing(str(file)) as stream, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Creating legend")  # it was slow: the machine is busy
        figure.savefig(stream, format="png", dpi=DPI)
    return str(file)
