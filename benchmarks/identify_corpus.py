"""Every recording of a corpus through `fbf identify`: a table of what it ends in, for docs/identify.md.

    python benchmarks/identify_corpus.py ../shared/corpus/resonance

A recording ends in a model or in one clear error; a traceback ends this.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from click.testing import CliRunner

from fbfcli.cli.identify import identify
from fbfcli.errors import FbfError

GUESSED = "x"  # where neither file nor name tells the axis


def axis_of(path: Path) -> str:
    """The axis that a file's name tells, as people and Klipper name their files."""
    words = path.stem.lower().replace("-", "_").split("_")
    return next((word[0] for word in words if word[:1] in ("x", "y") and not word[1:].strip("0123456789")), GUESSED)


def main(folder: str) -> None:
    print("| recording | ends in | modes: Hz (damping) | seconds |")
    print("|---|---|---|---|")
    for path in sorted(p for p in Path(folder).rglob("*") if p.is_file()):
        begin = time.process_time()
        arguments = [str(path), "--axis", axis_of(path), "--json", "-", "-q"]
        result = CliRunner().invoke(identify, arguments)
        spent = time.process_time() - begin
        name = f"`{path.parent.name}/{path.name}` {axis_of(path)}"
        if isinstance(result.exception, FbfError):
            words = str(result.exception).replace(str(path), path.name).replace("|", "/")
            print(f"| {name} | refused: {words} | | {spent:.1f} |")
            continue
        if result.exception:
            raise result.exception
        found = json.loads(result.stdout)
        modes = ", ".join(f"{m['frequency']['value']:.1f} ({m['damping']['value']:.3f})" for m in found["modes"])
        ends = found["fit"]["shape"] if "fit" in found else f"assumed: {found['assumed']}"
        print(f"| {name} | {ends} | {modes} | {spent:.1f} |")


if __name__ == "__main__":
    main(sys.argv[1])
