"""Recordings that people made, which lie beside the repository and not in it: tests of them are skipped without."""

from __future__ import annotations

from pathlib import Path

import pytest

RESONANCE = Path(__file__).parents[2] / "shared" / "corpus" / "resonance"
needs_resonance = pytest.mark.skipif(not RESONANCE.is_dir(), reason="the corpus is not here")
