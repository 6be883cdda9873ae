"""Measure `fbf simulate` on an hour of print: `python benchmarks/bench_simulate.py [--rate 1000] [--methods zv,ei]`.

A long print is generated in a temporary folder and simulated by one process on one core, with a printer of two modes
per axis: before and after compensation.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench_pipeline import MAKE_LONG, MB, ONE_THREAD

PRINTER = "synthetic_two_mode"
HOUR_S = 3600.0
MOVES = 253_000  # of make_long.py: an hour at this printer's limits
MOST_CPU_S, MOST_MB = 60.0, 500.0  # of an hour, before and after


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rate", type=int, default=1000)
    parser.add_argument("--methods", default="none,auto")
    parser.add_argument("--moves", type=int, default=MOVES)
    wanted = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):  # inherited by the process that is measured
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as folder:
        file, figures = Path(folder, "hour.gcode"), Path(folder, "figures.json")
        subprocess.run(
            [sys.executable, str(MAKE_LONG), str(file), "--moves", str(wanted.moves)],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        command = [sys.executable, "-m", "fbfcli.cli.main", "simulate", str(file), "-p", PRINTER, "-q",
                   "-m", wanted.methods, "--rate", str(wanted.rate), "--json", str(figures)]  # fmt: skip
        start = time.perf_counter()
        process = subprocess.Popen(command, env={**os.environ, **ONE_THREAD})
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, command)
        told = json.loads(figures.read_text())
    cpu, peak = used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / MB
    print("| method | print s | contour error RMS, um |\n|---|---|---|")
    for one in told["results"]:
        error = one["conditions"]["as modelled"]["total"]["contour"]["rms"]
        print(f"| {one['name']} | {one['time']:.0f} | {error:.1f} |")
    per_hour = cpu * HOUR_S / told["results"][0]["time"]
    print(f"\n{wanted.rate} Hz: {cpu:.1f} CPU s, {wall:.1f} s, {peak:.0f} MB; {per_hour:.1f} CPU s per hour of print")
    good = per_hour <= MOST_CPU_S and peak <= MOST_MB
    print(f"at most {MOST_CPU_S:.0f} CPU s an hour and {MOST_MB:.0f} MB: {'kept' if good else 'MISSED'}")
    sys.exit(not good)


if __name__ == "__main__":
    main()
