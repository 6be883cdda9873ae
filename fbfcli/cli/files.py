"""Files that appear whole or not at all, and text in either direction of a pipe."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, TextIO

from fbfcli.errors import FbfError

DASH = "-"
NEW_FILE = 0o666  # less the umask


@contextmanager
def reading(name: str) -> Iterator[BinaryIO]:
    """A file, or standard input. Raises FbfError where there is nothing to read."""
    if name == DASH:
        yield sys.stdin.buffer
        return
    path = Path(name)
    if path.is_dir():
        raise FbfError(f"{name}: is a directory, not a G-code file")
    with path.open("rb") as stream:
        yield stream


@contextmanager
def replacing(path: Path, like: Path | None = None) -> Iterator[BinaryIO]:
    """A new file beside `path` that takes its place when all has gone well; otherwise `path` stays as it was.

    like : its permissions are kept (`path` itself for a change in place)
    """
    target = Path(os.path.realpath(path))  # through a link, the file is changed and the link stays
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".tmp", dir=target.parent)
    try:
        with os.fdopen(handle, "w+b") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(name, stat.S_IMODE(like.stat().st_mode) if like else NEW_FILE & ~_umask())
        os.replace(name, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@contextmanager
def saying(name: str) -> Iterator[TextIO]:
    """A text file to write, or standard output."""
    if name == DASH:
        yield sys.stdout
        return
    with replacing(Path(name)) as raw:
        import io

        text = io.TextIOWrapper(raw, encoding="utf-8", write_through=True)
        yield text
        text.flush()
        text.detach()
