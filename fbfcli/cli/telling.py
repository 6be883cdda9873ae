"""What every verb tells: how far it is, its figures for scripts, and which file an error is about."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import click

from fbfcli.cli.files import DASH, saying
from fbfcli.errors import GcodeError, LimitError, ModelError

PER_MILLE = 1000


@contextmanager
def progress_bar(file: str, quiet: bool) -> Iterator[Callable[[int], None]]:
    """A bar on standard error, if that is a terminal and the file's size is known; takes the bytes read so far."""
    if quiet or file == DASH or not sys.stderr.isatty():
        yield lambda done: None
        return
    with click.progressbar(length=Path(file).stat().st_size, label=Path(file).name, file=sys.stderr) as bar:  # type: ignore[var-annotated]
        yield lambda done: bar.update(done - bar.pos)


@contextmanager
def fraction_bar(label: str, quiet: bool) -> Iterator[Callable[[float], None]]:
    """A bar on standard error, if that is a terminal; takes the fraction that is done."""
    if quiet or not sys.stderr.isatty():
        yield lambda done: None
        return
    with click.progressbar(length=PER_MILLE, label=label, file=sys.stderr) as bar:  # type: ignore[var-annotated]
        yield lambda done: bar.update(round(done * PER_MILLE) - bar.pos)


@contextmanager
def named(file: str, profile: str) -> Iterator[None]:
    """Errors get the name of the file they are about."""
    try:
        yield
    except GcodeError as error:
        raise error.at(file) from None
    except LimitError as error:
        raise LimitError(f"{file}: {error}") from None
    except ModelError as error:
        raise ModelError(f"{profile}: {error}") from None


def tell_json(name: str, figures: Mapping[str, object]) -> None:
    """A verb's figures, to a file or (-) to standard output."""
    with saying(name) as say:
        say(json.dumps(figures, indent=2) + "\n")
