"""What all tests share: where the repository is, and how hypothesis searches."""

from __future__ import annotations

import os
import signal
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: small matrices only wait for threads

import pytest
from hypothesis import HealthCheck, settings
from part_cases import PART

# a shell in the background has Ctrl-C ignored, and all that is started from it inherits that: tests send it
signal.signal(signal.SIGINT, signal.default_int_handler)

# machines that are shared are slow at times: no deadline; in CI the same examples every time, elsewhere new ones
settings.register_profile("fbf", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.register_profile("ci", settings.get_profile("fbf"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "fbf")


@pytest.fixture(scope="session")
def root() -> Path:
    """Top of the repository."""
    return Path(__file__).parents[1]


@pytest.fixture
def nobody(monkeypatch, tmp_path, root):
    """A user without a printer, in an empty folder."""
    monkeypatch.delenv("FBF_PRINTER", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("PYTHONPATH", str(root))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")


@pytest.fixture
def part(tmp_path) -> Path:
    """A small print in a folder of its own, with a blank in its name."""
    file = tmp_path / "prints" / "my part.gcode"
    file.parent.mkdir()
    file.write_text(PART)
    return file
