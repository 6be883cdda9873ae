"""A printer of each firmware, and the corpus of real files beside the repository."""

from __future__ import annotations

from pathlib import Path

import pytest

CORPUS = Path(__file__).parents[2].parent / "shared" / "corpus" / "gcode"
TEXT_FILES = sorted(CORPUS.glob("*.gcode"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """`corpus_file` runs over every text file of the corpus."""
    if "corpus_file" in metafunc.fixturenames:
        absent = pytest.param(None, marks=pytest.mark.skip(reason="the corpus of real files is not here"))
        metafunc.parametrize("corpus_file", TEXT_FILES or [absent], ids=lambda file: getattr(file, "stem", "none"))


@pytest.fixture
def corpus() -> Path:
    if not CORPUS.exists():
        pytest.skip("the corpus of real files is not here")
    return CORPUS
