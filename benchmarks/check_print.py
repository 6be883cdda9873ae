"""Check that a compensated file is still the print it was made from.

    python benchmarks/check_print.py part.gcode part.fbf.gcode -p taz6
    python benchmarks/check_print.py --corpus DIR [-p PRINTER] [--accel A]

The laws are in `same_print`. With --corpus every .gcode and .nc of a folder is compensated first, with the bundled taz6
or, where that machine cannot print the file, with a profile derived from it (`fitting_profile`). The table tells how
well each written file is followed, executed by the planner model: `follow` against the polyline that it stands for and
`drift` of the clock, which count in the verdict, and `chord`, that polyline against the smooth command, which does not.
Where that is more than what is asked of `follow`, as on boards that take few segments, the table says `over`.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

from fitting_profile import BASE, fitting_profile
from same_print import Reading, check

from fbfcli.cli.lookup import find_printer
from fbfcli.cli.main import run

FOLLOW_RMS, FOLLOW_MAX = 3.0, 15.0  # um
DRIFT = 5.0  # ppm
HEAD = (
    "| file | profile | lines | print time [s] | segments/s | follow rms, max [um] | drift [ppm] "
    "| chord rms, max [um] | contour rms [um] | ran [s] | verdict |\n|---|---|---|---|---|---|---|---|---|---|---|"
)


def is_refused(written: Path, profile: str) -> list[str]:
    """A second pass must end with exit code 1, one line, and no file."""
    said = StringIO()
    target = written.with_name("second" + written.suffix)
    with redirect_stderr(said):
        code = run(["compensate", str(written), "-p", profile, "-o", str(target)])
    good = code == 1 and said.getvalue().count("\n") == 1 and not target.exists()
    return [] if good else [f"a second pass is not refused: exit code {code}, {said.getvalue()!r}"]


def check_corpus(folder: Path, say: Callable[[str], object], profile: str | None, more: Sequence[str] = ()) -> bool:
    """Compensate and check every file of a folder; says a table."""
    say(HEAD)
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        for file in sorted([*folder.glob("*.gcode"), *folder.glob("*.nc")]):
            row, failures = checked(file, Path(scratch), profile, more)
            say(f"| {file.name} | {row} | {'**' + '; '.join(failures) + '**' if failures else 'good'} |")
            good &= not failures
    return good


def checked(
    file: Path, scratch: Path, profile: str | None = None, more: Sequence[str] = ()
) -> tuple[str, list[str]]:
    """Compensate one file into `scratch` and check it: what is to be said, and failures.

    profile : None: a fitting one;   more : options of `fbf compensate`
    """
    profile, about = (profile, profile) if profile else fitting_profile(file.read_bytes(), scratch)
    written, figures = scratch / f"{file.stem}.fbf{file.suffix}", scratch / "figures.json"
    said, started = StringIO(), time.perf_counter()
    with redirect_stderr(said):
        code = run(["compensate", str(file), "-p", profile, "-o", str(written), "--json", str(figures), "-q", *more])
    took = time.perf_counter() - started
    if code:
        return f"{about} | | | | | | | | {took:.1f}", [f"exit code {code}: {said.getvalue().strip()}"]
    printer = find_printer(profile)
    original, text = file.read_bytes(), written.read_bytes()
    told = json.loads(figures.read_text())
    failures = check(original, text, printer) + is_refused(written, profile) + is_not_followed(told)
    seconds = [Reading.of(t, printer).seconds for t in (original, text)]
    chord, before, after = told["chord_error"], told["contour_before"], told["contour_after"]
    cells = (
        about, f"{original.count(10)} -> {text.count(10)}", f"{seconds[0]:.0f} -> {seconds[1]:.0f}",
        f"{told['segments_per_second']:.0f} of {told['budget']:.0f}", _figures(told["follow_error"]),
        f"{told['clock_drift_ppm']:+.2f}", _figures(chord) + ("" if _is_close(chord) else " over"),
        f"{before['rms']:.1f} -> {after['rms']:.1f}", f"{took:.1f}",
    )  # fmt: skip
    return " | ".join(cells), failures


def _figures(error: dict[str, float]) -> str:
    return f"{error['rms']:.2f}, {error['max']:.1f}"


def _is_close(error: dict[str, float]) -> bool:
    return error["rms"] <= FOLLOW_RMS and error["max"] <= FOLLOW_MAX


def is_not_followed(told: dict[str, Any]) -> list[str]:
    """Failures of the figures that --json tells."""
    follow, drift = told["follow_error"], told["clock_drift_ppm"]
    failures = [] if _is_close(follow) else [f"followed to {_figures(follow)} um"]
    return failures + ([] if abs(drift) <= DRIFT else [f"the clock drifts by {drift:.1f} ppm"])


def _failures(wanted: argparse.Namespace) -> Iterator[str]:
    profile = wanted.printer or BASE
    yield from check(wanted.original.read_bytes(), wanted.written.read_bytes(), find_printer(profile))
    yield from is_refused(wanted.written, profile)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("original", type=Path, nargs="?")
    parser.add_argument("written", type=Path, nargs="?")
    parser.add_argument("-p", "--printer", help="the profile it was compensated with (default: taz6); or is to be")
    parser.add_argument("--accel", metavar="A", help="compensate the files of the folder with this acceleration")
    parser.add_argument("--corpus", type=Path, metavar="DIR", help="compensate and check every file of a folder")
    wanted = parser.parse_args()
    if wanted.corpus:
        more = ["--accel", wanted.accel] if wanted.accel else []
        return 0 if check_corpus(wanted.corpus, print, wanted.printer, more) else 1
    if not wanted.written:
        parser.error("two files, or --corpus")
    failures = list(_failures(wanted))
    print("\n".join(failures) or "good: every line, the filament, the end, the limits")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
