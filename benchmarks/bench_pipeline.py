"""Measure `fbf compensate` on long prints: `python benchmarks/bench_pipeline.py [file.gcode ...] [--profile]`.

Without files, a print of 1,000,000 moves and one of 200 MB are generated in a temporary folder. Each is compensated by
one process on one core. `--profile` tells where the time goes, room by room, and the functions that take most of it.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import os
import pstats
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
MB = 1 << 20
LEAST_PRINT_S = 1000.0  # per CPU-second
LEAST_MOVES = 40_000.0  # per CPU-second
MOST_MB = 400.0
MAKE_LONG = Path(__file__).with_name("make_long.py")
PACKAGE = Path(__file__).parents[1] / "fbfcli"
JOBS = {"moves.gcode": ("--moves", "1000000"), "size.gcode": ("--size", "200000000")}
TOP = 25  # functions told by --profile


@dataclass(frozen=True)
class Measured:
    """One file compensated by one process.

    moves, segments, input_mb : of the file, and written
    print_s, wall_s, cpu_s    : time of the print; of the process, start-up included [s]
    peak_mb                   : largest resident memory
    """

    name: str
    moves: int
    segments: int
    input_mb: float
    print_s: float
    wall_s: float
    cpu_s: float
    peak_mb: float

    HEAD = (
        "| file | input MB | moves | segments | print s | CPU s | wall s | moves / CPU s | print s / CPU s | peak MB |",
        "|---|---|---|---|---|---|---|---|---|---|",
    )

    @property
    def row(self) -> str:
        """One line of the table."""
        cells = (self.name, f"{self.input_mb:.0f}", self.moves, self.segments, f"{self.print_s:.0f}",
                 f"{self.cpu_s:.1f}", f"{self.wall_s:.1f}", f"{self.moves / self.cpu_s:.0f}",
                 f"{self.print_s / self.cpu_s:.0f}", f"{self.peak_mb:.0f}")  # fmt: skip
        return f"| {' | '.join(map(str, cells))} |"

    @property
    def good(self) -> bool:
        return (self.print_s >= LEAST_PRINT_S * self.cpu_s and self.moves >= LEAST_MOVES * self.cpu_s
                and self.peak_mb <= MOST_MB)  # fmt: skip


def measure(file: Path, printer: str, method: str, scratch: Path) -> Measured:
    """Compensate `file` in a process of its own, on one core. Raises CalledProcessError."""
    summary, out = scratch / "summary.json", scratch / "out.gcode"
    command = [sys.executable, "-m", "fbfcli.cli.main", "compensate", str(file), "-p", printer, "-m", method,
               "-o", str(out), "--json", str(summary), "-q"]  # fmt: skip
    start = time.perf_counter()
    process = subprocess.Popen(command, env={**os.environ, **ONE_THREAD})
    _, status, used = os.wait4(process.pid, 0)  # getrusage(RUSAGE_CHILDREN) would give the largest of all children
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    told = json.loads(summary.read_text())
    out.unlink()
    return Measured(file.name, told["moves"], told["segments"], file.stat().st_size / 1e6, told["time"], wall,
                    used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / MB)  # fmt: skip


def profiled(file: Path, printer: str, method: str, scratch: Path) -> str:
    """Where the time of one compensation goes: a table by room and one by function."""
    from fbfcli.cli.lookup import find_printer
    from fbfcli.gcode.scan import chunks
    from fbfcli.pipeline import Settings, compensate

    profile = cProfile.Profile()
    with file.open("rb") as source, (scratch / "out.gcode").open("wb") as sink:
        profile.enable()
        settings = Settings(method=method)
        compensate(chunks(source), find_printer(printer), settings, lambda text: sink.write(text) and None)
        profile.disable()
    own = own_times(pstats.Stats(profile))
    rooms: dict[str, float] = defaultdict(float)
    for (module, _), seconds in own.items():
        rooms[module.split("/")[0]] += seconds
    total = sum(own.values())
    lines = [f"{total:.2f} s under the profiler, which slows short calls", "", "| room | s | share |", "|---|---|---|"]
    lines += [f"| {room} | {s:.2f} | {s / total:.0%} |" for room, s in sorted(rooms.items(), key=lambda item: -item[1])]
    lines += ["", "| function, with the library calls it makes | s | share |", "|---|---|---|"]
    top = sorted(own.items(), key=lambda item: -item[1])[:TOP]
    return "\n".join(lines + [f"| {module} `{name}` | {s:.2f} | {s / total:.0%} |" for (module, name), s in top])


def own_times(stats: pstats.Stats) -> dict[tuple[str, str], float]:
    """Seconds of each function of the package, calls that leave the package included: {(module, name): s}."""
    own: dict[tuple[str, str], float] = defaultdict(float)
    for (file, _, name), (_, _, inner, _, callers) in stats.stats.items():  # type: ignore[attr-defined]
        if module := _module(file):
            own[module, name] += inner
        else:
            for (caller, _, by), (_, _, _, spent) in callers.items():
                if module := _module(caller):
                    own[module, by] += spent
    return own


def _module(file: str) -> str:
    """motion/sample.py for a file of the package, nothing for another."""
    path = Path(file)
    return path.relative_to(PACKAGE).as_posix() if path.is_relative_to(PACKAGE) else ""


def made(scratch: Path) -> list[Path]:
    """The two long prints."""
    for name, size in JOBS.items():
        command = [sys.executable, str(MAKE_LONG), str(scratch / name), *size]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return [scratch / name for name in JOBS]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", type=Path, nargs="*")
    parser.add_argument("-p", "--printer", default="synthetic_bed_slinger")
    parser.add_argument("-m", "--method", default="lpfbs")
    parser.add_argument("--profile", action="store_true", help="where the time goes, of the first file")
    wanted = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):  # inherited by the processes that are measured
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    os.environ.update(ONE_THREAD)
    with tempfile.TemporaryDirectory() as folder:
        files = wanted.files or made(Path(folder))
        if wanted.profile:
            print(profiled(files[0], wanted.printer, wanted.method, Path(folder)))
            return
        print("\n".join(Measured.HEAD))
        good = True
        for file in files:
            measured = measure(file, wanted.printer, wanted.method, Path(folder))
            print(measured.row, flush=True)
            good &= measured.good
    asked = f"at least {LEAST_PRINT_S:.0f} print s and {LEAST_MOVES:.0f} moves per CPU s, at most {MOST_MB:.0f} MB"
    print(f"\n{asked}: {'kept' if good else 'MISSED'}")
    sys.exit(not good)


if __name__ == "__main__":
    main()
