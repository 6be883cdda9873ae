"""Measure `fbf steps`: `python benchmarks/bench_steps.py [file.gcode ...] [--formats compact csv ...]`.

Without files, prints of 100,000 and of 1,000,000 moves are generated in a temporary folder: the memory must not grow
with the length. Each is streamed by one process on one core; the stream goes to the null device.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench_pipeline import MAKE_LONG, MB, ONE_THREAD

LEAST_STEPS = 5e6  # per CPU second, of the formats that are made for it
MOST_MB = 300.0
SWIFT = ("compact", "npz", "positions", "marlin")  # text for people is slower
MOVES = (100_000, 1_000_000)
LONG = 50e6  # steps: in a shorter stream the start counts, mostly the method's design


@dataclass(frozen=True)
class Measured:
    """One file streamed by one process: print and CPU time, start-up included [s], and its largest memory."""

    file: str
    format: str
    method: str
    steps: int
    size: int
    print_s: float
    cpu_s: float
    peak_mb: float

    HEAD = (
        "| file | method | format | steps | print s | CPU s | million steps / CPU s | bytes / step | peak MB |",
        "|---|---|---|---|---|---|---|---|---|",
    )

    @property
    def row(self) -> str:
        """One line of the table."""
        cells = (self.file, self.method, self.format, f"{self.steps:,}", f"{self.print_s:.0f}", f"{self.cpu_s:.1f}",
                 f"{self.steps / self.cpu_s / 1e6:.1f}", f"{self.size / self.steps:.2f}",
                 f"{self.peak_mb:.0f}")  # fmt: skip
        return f"| {' | '.join(cells)} |"

    @property
    def good(self) -> bool:
        swift = self.format not in SWIFT or self.steps < LONG or self.steps >= LEAST_STEPS * self.cpu_s
        return swift and self.peak_mb <= MOST_MB


def measure(file: Path, printer: str, method: str, form: str, scratch: Path) -> Measured:
    """Stream `file` in a process of its own. Raises CalledProcessError."""
    summary = scratch / "summary.json"
    command = [sys.executable, "-m", "fbfcli.cli.main", "steps", str(file), "-p", printer, "-m", method, "-t", form,
               "-o", os.devnull, "--json", str(summary), "-q"]  # fmt: skip
    process = subprocess.Popen(command, env={**os.environ, **ONE_THREAD, "TMPDIR": str(scratch)})
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    told = json.loads(summary.read_text())
    return Measured(file.name, form, method, sum(motor["steps"] for motor in told["motors"]), told["bytes"],
                    told["time"], used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / MB)  # fmt: skip


def made(scratch: Path) -> list[Path]:
    """The generated prints."""
    files = [scratch / f"{moves}_moves.gcode" for moves in MOVES]
    for file, moves in zip(files, MOVES, strict=True):
        command = [sys.executable, str(MAKE_LONG), str(file), "--moves", str(moves)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return files


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", type=Path, nargs="*")
    parser.add_argument("-p", "--printer", default="synthetic_bed_slinger")
    parser.add_argument("-m", "--method", default="lpfbs")
    parser.add_argument("--formats", nargs="+", default=["compact", "npz", "positions", "marlin", "csv", "vcd"])
    wanted = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as folder:
        files = wanted.files or made(Path(folder))
        print("\n".join(Measured.HEAD))
        good = True
        for i, file in enumerate(files):
            for form in wanted.formats if i == 0 else wanted.formats[:1]:  # of the long one, the first format
                measured = measure(file, wanted.printer, wanted.method, form, Path(folder))
                print(measured.row, flush=True)
                good &= measured.good
    print(f"\n{', '.join(SWIFT)}: at least {LEAST_STEPS / 1e6:.0f} million steps per CPU s in a long stream; "
          f"at most {MOST_MB:.0f} MB: {'kept' if good else 'MISSED'}")  # fmt: skip
    sys.exit(not good)


if __name__ == "__main__":
    main()
