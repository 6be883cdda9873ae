"""Check that a compensated file is still the print it was made from.

    python benchmarks/check_print.py part.gcode part.fbf.gcode -p taz6
    python benchmarks/check_print.py --corpus DIR

The laws are in `same_print`. With --corpus every .gcode and .nc of a folder is compensated first, with the bundled taz6
or, where that machine cannot print the file, with a profile derived from it (`fitting_profile`).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

from fitting_profile import fitting_profile
from same_print import Reading, check

from fbfcli.cli.lookup import find_printer
from fbfcli.cli.main import run


def is_refused(written: Path, profile: str) -> list[str]:
    """A second pass must end with exit code 1, one line, and no file."""
    said = StringIO()
    target = written.with_name("second" + written.suffix)
    with redirect_stderr(said):
        code = run(["compensate", str(written), "-p", profile, "-o", str(target)])
    good = code == 1 and said.getvalue().count("\n") == 1 and not target.exists()
    return [] if good else [f"a second pass is not refused: exit code {code}, {said.getvalue()!r}"]


def check_corpus(folder: Path, say: Callable[[str], object]) -> bool:
    """Compensate and check every file of a folder; says a table."""
    say("| file | profile | lines | print time [s] | ran [s] | verdict |\n|---|---|---|---|---|---|")
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        for file in sorted([*folder.glob("*.gcode"), *folder.glob("*.nc")]):
            row, failures = checked(file, Path(scratch))
            say(f"| {file.name} | {row} | {'**' + '; '.join(failures) + '**' if failures else 'good'} |")
            good &= not failures
    return good


def checked(file: Path, scratch: Path) -> tuple[str, list[str]]:
    """Compensate one file into `scratch` and check it: what is to be said, and failures."""
    profile, about = fitting_profile(file.read_bytes(), scratch)
    written = scratch / f"{file.stem}.fbf{file.suffix}"
    said, started = StringIO(), time.perf_counter()
    with redirect_stderr(said):
        code = run(["compensate", str(file), "-p", profile, "-o", str(written), "-q"])
    took = time.perf_counter() - started
    if code:
        return f"{about} | | | {took:.1f}", [f"exit code {code}: {said.getvalue().strip()}"]
    printer = find_printer(profile)
    original, text = file.read_bytes(), written.read_bytes()
    failures = check(original, text, printer) + is_refused(written, profile)
    seconds = [Reading.of(t, printer).seconds for t in (original, text)]
    lines = f"{original.count(10)} -> {text.count(10)}"
    return f"{about} | {lines} | {seconds[0]:.0f} -> {seconds[1]:.0f} | {took:.1f}", failures


def _failures(wanted: argparse.Namespace) -> Iterator[str]:
    yield from check(wanted.original.read_bytes(), wanted.written.read_bytes(), find_printer(wanted.printer))
    yield from is_refused(wanted.written, wanted.printer)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("original", type=Path, nargs="?")
    parser.add_argument("written", type=Path, nargs="?")
    parser.add_argument("-p", "--printer", default="taz6", help="the profile it was compensated with")
    parser.add_argument("--corpus", type=Path, metavar="DIR", help="compensate and check every file of a folder")
    wanted = parser.parse_args()
    if wanted.corpus:
        return 0 if check_corpus(wanted.corpus, print) else 1
    if not wanted.written:
        parser.error("two files, or --corpus")
    failures = list(_failures(wanted))
    print("\n".join(failures) or "good: every line, the filament, the end, the limits")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
