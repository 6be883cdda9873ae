"""Real files of eleven slicers, compensated and proved to be the same print."""

from __future__ import annotations

from pathlib import Path

import pytest
from check_print import checked

from fbfcli.cli import main

CORPUS = Path(__file__).parents[2] / "shared" / "corpus" / "gcode"
FILES = sorted([*CORPUS.glob("*.gcode"), *CORPUS.glob("*.nc")])
MOST_LINES = 20_000  # of a long file: what is to be found is found in them

needs_corpus = pytest.mark.skipif(not FILES, reason="the corpus of real files is not here")


def head(file: Path) -> bytes:
    return b"".join(file.read_bytes().splitlines(keepends=True)[:MOST_LINES])


@needs_corpus
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_real_file_is_still_the_same_print(file, tmp_path):
    start = tmp_path / file.name
    start.write_bytes(head(file))
    _, failures = checked(start, tmp_path)
    assert not failures, "\n".join(failures)


@needs_corpus
@pytest.mark.parametrize("file", sorted(CORPUS.glob("*.bgcode")), ids=lambda file: file.stem)
def test_binary_gcode_is_refused_by_name(file, tmp_path, capsys):
    assert main.run(["compensate", str(file), "-p", "taz6", "-o", str(tmp_path / "out")]) == 1
    said = capsys.readouterr()
    assert not said.out
    assert said.err.count("\n") == 1
    assert file.name in said.err
    assert "binary G-code" in said.err
    assert not list(tmp_path.iterdir())
