"""Files that appear whole or not at all, and text in either direction of a pipe."""

from __future__ import annotations

import io
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import click

from fbfcli.errors import FbfError

DASH = "-"
NEW_FILE = 0o666  # less the umask


@contextmanager
def reading(name: str) -> Iterator[BinaryIO]:
    """A file, or standard input. Raises FbfError where there is nothing to read, UsageError where nobody sends it."""
    if name == DASH:
        if sys.stdin.isatty():
            raise click.UsageError("no FILE, and standard input is a terminal")
        yield sys.stdin.buffer
        return
    path = Path(name)
    if path.is_dir():
        raise FbfError(f"{name}: is a directory, not a file")
    with path.open("rb") as stream:
        yield stream


@contextmanager
def rereading(name: str) -> Iterator[tuple[Callable[[], BinaryIO], int]]:
    """What gives a file from its beginning as often as it is asked, and its size; a pipe's text is kept meanwhile.

    Raises FbfError where there is nothing to read.
    """
    with ExitStack() as files:
        source = files.enter_context(reading(name))
        if name == DASH or not Path(name).is_file():
            kept = files.enter_context(tempfile.TemporaryFile())
            shutil.copyfileobj(source, kept)
            source = kept  # type: ignore[assignment]

        def again() -> BinaryIO:
            source.seek(0)
            return source

        yield again, source.seek(0, os.SEEK_END)


def is_stream(name: str) -> bool:
    """Standard output, a pipe or a device: text goes there as it comes, nothing can be put right afterwards."""
    path = Path(name)
    return name == DASH or (path.exists() and not path.is_file() and not path.is_dir())


def check_targets(read: Sequence[str], *written: str | None) -> None:
    """Refuse before any work what could not be written after it, or would be written over what is read or written."""
    inputs = {os.path.realpath(name) for name in read if name != DASH}
    outputs: set[str] = set()
    for name in filter(None, written):
        if name == DASH:
            continue
        if not Path(name).absolute().parent.is_dir():
            raise FbfError(f"{name}: there is no folder {Path(name).parent}")
        place = os.path.realpath(name)
        if place in inputs:
            raise click.UsageError(f"{name} is FILE itself: give another name")
        if place in outputs:
            raise click.UsageError(f"two things would be written to {name}: give one of them another name")
        if not is_stream(name):  # a device may take several
            outputs.add(place)


def one_stream(*written: str | None) -> None:
    """Refuse to write two things to standard output."""
    if written.count(DASH) > 1:
        raise click.UsageError("two things would go to standard output: give one of them a file")


@contextmanager
def streaming(name: str) -> Iterator[BinaryIO]:
    """What `is_stream`, to be written."""
    if name == DASH:
        yield sys.stdout.buffer
        return
    with io.BufferedWriter(_Named(name, "w")) as stream:
        yield stream


@contextmanager
def replacing(name: str) -> Iterator[BinaryIO]:
    """A new file that takes the place of the one called `name` when all has gone well; else that stays as it was."""
    target = Path(os.path.realpath(name))  # through a link, the file is changed and the link stays
    if target.is_dir():
        raise FbfError(f"{name}: is a directory")
    mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else NEW_FILE & ~_umask()
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".tmp", dir=target.parent)
    except OSError as error:
        raise FbfError(f"{name}: cannot be written: {error.strerror}") from None
    os.close(handle)
    try:
        named = _Named(temporary, "r+")
        with io.BufferedRandom(named) as stream:
            yield stream
            stream.flush()
            named.sync()
        os.chmod(temporary, mode)
        os.replace(temporary, target)
    except BaseException as error:
        with suppress(OSError):
            os.unlink(temporary)
        if isinstance(error, OSError) and error.filename == temporary:
            raise FbfError(f"{name}: cannot be written: {error.strerror}; it stays as it was") from None
        raise


class _Named(io.FileIO):
    """A file whose failures carry its name: of several that are open, the one that failed is told."""

    def write(self, data: Any) -> int:
        with self._telling():
            return super().write(data)

    def sync(self) -> None:
        """To the disk: some are found to be full only now."""
        with self._telling():
            os.fsync(self.fileno())

    @contextmanager
    def _telling(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise OSError(error.errno, error.strerror, self.name) from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def writing(name: str) -> AbstractContextManager[BinaryIO]:
    """A file that appears whole or not at all, or what `is_stream`."""
    return streaming(name) if is_stream(name) else replacing(name)


@contextmanager
def saying(name: str) -> Iterator[Callable[[str], object]]:
    """Writes text to a file, or to what `is_stream`."""
    with writing(name) as stream:
        yield lambda text: stream.write(text.encode())
