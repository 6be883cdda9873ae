"""Pictures from outside: `fbf simulate --report --png`, `fbf compensate --report`, and what cannot be drawn."""

from __future__ import annotations

import json
import re

import pytest
from part_cases import names

from fbfcli.cli import main

pytestmark = pytest.mark.usefixtures("nobody")
SIMULATE, COMPENSATE = (["simulate", "-p", "taz6", "-q"], ["compensate", "-p", "taz6", "-q"])


def run(*words: object) -> int:
    return main.run([str(word) for word in words])


def data(page: str) -> dict:
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])


def test_a_simulation_is_drawn_before_and_after(part):
    page, png = part.with_name("a page.html"), part.with_name("corner.png")
    assert run(*SIMULATE, part, "--report", page, "--png", png) == 0
    assert png.read_bytes().startswith(b"\x89PNG")
    text = page.read_text()
    numbers = data(text)
    assert "my part.gcode" in text and numbers["methods"][0] == "as sliced" and len(numbers["methods"]) == 2
    after = numbers["methods"][1]
    assert after not in ("auto", "none")
    assert numbers["corners"][0]["method"] == "as sliced" and after in numbers["corners"][0]["windows"]
    assert numbers["layers"] and set(numbers["layers"][0]["nozzle"]) == {"as sliced", after}
    assert numbers["segments"][after] and numbers["byLayer"][after]["rms"] and len(numbers["plants"]) == 2
    for words in ("Method against method", "Corners and ringing", "Settings and versions", "Predicted for"):
        assert words in text


def test_methods_mismatch_and_accelerations_become_tables(part):
    page = part.with_name("p.html")
    assert run(*SIMULATE, part, "-m", "none,zv,lpfbs", "--mismatch", 10, "--accel", "1000,2000", "--report", page) == 0
    text = page.read_text()
    assert data(text)["methods"] == ["as sliced", "zv", "lpfbs"]  # with the first acceleration
    assert "If the machine is not as modelled" in text and "Print time against error" in text and "2,000" in text


def test_compensating_draws_the_same_page_in_one_pass_and_writes_the_same_text(part):
    page, plain, drawn = (part.with_name(name) for name in ("p.html", "plain.g", "drawn.g"))
    assert run(*COMPENSATE, part, "-m", "lpfbs", "-o", plain) == 0
    assert run(*COMPENSATE, part, "-m", "lpfbs", "-o", drawn, "--report", page) == 0
    assert drawn.read_bytes() == plain.read_bytes()
    numbers = data(page.read_text())
    assert numbers["methods"] == ["as sliced", "lpfbs"]
    largest = [
        max(corner["error"] for corner in numbers["corners"] if corner["method"] == name) for name in numbers["methods"]
    ]
    assert largest[1] < largest[0]
    assert set(numbers["corners"][0]["windows"]) == set(numbers["methods"])


def test_a_file_that_is_compensated_is_drawn_as_it_is(part):
    page = part.with_name("p.html")
    assert run(*COMPENSATE, part) == 0
    assert run(*SIMULATE, part.with_name("my part.fbf.gcode"), "--report", page, "--png", part.with_name("p.png")) == 0
    assert data(page.read_text())["methods"] == ["as written"]


def test_a_file_without_motion_has_a_page_and_no_corner(part, capsys):
    part.write_text("M104 S200\nM84\n")
    page = part.with_name("p.html")
    assert run(*SIMULATE, part, "--report", page) == 0
    assert data(page.read_text())["corners"] == []
    assert run(*SIMULATE, part, "--png", part.with_name("p.png")) == 1
    assert "no corner to draw" in capsys.readouterr().err
    assert "p.png" not in names(part)


@pytest.mark.parametrize("verb", (SIMULATE, COMPENSATE))
def test_nothing_is_written_twice_or_over_what_is_read(part, capsys, verb):
    for words in (["--report", part], ["--report", "x.html", "--json", "x.html"], ["--report", "-", "--json", "-"]):
        assert run(*verb, part, *words) == 2
    assert run(*verb, part, "--report", part.parent / "none" / "p.html") == 1
    assert "Usage" in capsys.readouterr().err and names(part) == ["my part.gcode"]
