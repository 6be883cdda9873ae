"""Real recordings through `fbf identify`: published answers are met, and nothing ends in a traceback."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from resonance_corpus import RESONANCE, needs_resonance

from fbfcli.cli.identify import identify
from fbfcli.errors import FbfError

pytestmark = needs_resonance
PUBLISHED_HZ = np.array([10, 15, 20, 25, 30, 35, 40, 50.0])  # at which the gain is compared
ULENDO_HZ = 43.0


def found(*arguments: object) -> dict:
    result = CliRunner().invoke(identify, [*map(str, arguments), "--json", "-", "-q"], catch_exceptions=False)
    return json.loads(result.stdout)


@pytest.mark.parametrize(
    "file",
    ["commanded_measured/ulendo_ender3v2neo_y_240529_143933_paired.csv", "ulendo/ender3v2neo_y_240529_143933.json"],
)
def test_ulendo_s_published_answer(file):
    told = json.loads(json.loads((RESONANCE / "ulendo" / "json_response_240529_143933.json").read_text())["gui_data"])
    answer = found(RESONANCE / file, "--axis", "y")
    seen = answer["response"]
    gain = np.interp(PUBLISHED_HZ, seen["frequency"], seen["magnitude"])
    published = np.interp(PUBLISHED_HZ, np.array(told["bp"]) / (2 * np.pi), told["g"])
    assert np.abs(gain / published - 1).max() < 0.03
    assert answer["modes"][0]["frequency"]["value"] == pytest.approx(ULENDO_HZ, rel=0.03)


def test_every_recording_ends_in_a_model_or_in_one_line():
    small = [path for path in sorted(RESONANCE.rglob("*")) if path.is_file() and path.stat().st_size < 300_000]
    assert len(small) > 12
    ends = []
    for path in small:
        result = CliRunner().invoke(identify, [str(path), "--axis", "x", "--json", "-", "-q"])
        if result.exception is not None:
            assert isinstance(result.exception, FbfError), path
            assert "\n" not in str(result.exception)
        ends.append(result.exception is None)
    assert sum(ends) >= 6
