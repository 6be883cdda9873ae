"""Draw docs/before_after.png and docs/report.png: the ringing tower simulated, before and after.

Both come from one `fbf simulate`; the second is the head of its page as headless Chromium shows it.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from fbfcli.cli import main

ROOT = Path(__file__).parents[1]
PART = ROOT / "sample_gcode" / "ringing_tower.gcode"
CORNER, REPORT = ROOT / "docs" / "before_after.png", ROOT / "docs" / "report.png"
SIMULATE = ("simulate", str(PART), "-p", "synthetic_bed_slinger", "-m", "none,lpfbs", "--accel", "5000")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WIDE, HIGH = 1300, 1290
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=10000")
# the first of the worst corners of an outer wall, as a reader who has clicked on it sees it
CLICK = """<script>addEventListener("load", () => setTimeout(() => [...document.querySelectorAll("#chips span")]
  .find(each => each.textContent === "External perimeter").nextElementSibling.click(), 500));</script>"""


def browser() -> str:
    """Where Chromium is."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    return found or sys.exit("no Chromium here: docs/report.png stays as it was")


def photograph(page: Path, picture: Path) -> None:
    """The head of a page."""
    page.write_text(page.read_text(encoding="utf-8").replace("</body>", CLICK + "</body>"), encoding="utf-8")
    words = [browser(), *FLAGS, f"--window-size={WIDE},{HIGH}", f"--screenshot={picture}", page.as_uri()]
    subprocess.run(words, check=True, capture_output=True, timeout=120)


def draw(folder: Path) -> None:
    page = folder / "report.html"
    if main.run([*SIMULATE, "--report", str(page), "--png", str(CORNER)]):
        sys.exit(1)
    photograph(page, REPORT)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    with tempfile.TemporaryDirectory() as made:
        draw(Path(made))
