"""A page opened in headless Chromium: what it asks the network for, what it complains of, and what its script does.

The page is opened as it is, with a script of the test behind its own. No driver: what the script finds out is read from
the page itself, as Chromium leaves it.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from html import unescape
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FOUND = next((path for name in NAMES if (path := shutil.which(name))), None)
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-default-apps",
         "--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1300,1000", "--virtual-time-budget=20000",
         "--enable-logging=stderr")  # fmt: skip
LISTEN = """<script>window.complaints = [];
addEventListener("error", e => complaints.push(String(e.message)));
addEventListener("unhandledrejection", e => complaints.push(String(e.reason)));
document.addEventListener("securitypolicyviolation", e => complaints.push("loads " + e.blockedURI));
console.error = console.warn = (...words) => complaints.push(words.join(" "));
</script>"""
TELL = """<script>addEventListener("load", async () => {
  const told = {};
  try { await (async told => { %s })(told); } catch (error) { complaints.push("test: " + error); }
  told.complaints = complaints;
  told.loaded = performance.getEntriesByType("resource").map(each => each.name);
  const pre = document.createElement("pre");
  pre.id = "told-to-the-test";
  pre.textContent = JSON.stringify(told);
  document.body.append(pre);
});</script>"""


@dataclass(frozen=True)
class Opened:
    """What a page did.

    told    : what the script put there, and `complaints` and addresses `loaded`, as the page saw them
    console : Chromium's messages about it
    asked   : what it asked for, by Chromium's log of requests, which also has what Chromium asks for itself
    """

    told: dict[str, Any]
    console: list[str]
    asked: list[str]


def opened(page: str, script: str, folder: Path) -> Opened:
    """What a page does when a script (of an async function, `told` being its result) has been run in it."""
    assert FOUND
    file, log = folder / "page.html", folder / "net.json"
    head, body = page.split("<head>", 1)
    meta = re.match(r"(?s).*?Content-Security-Policy[^>]*>", body)
    at = meta.end() if meta else 0
    file.write_text(f"{head}<head>{body[:at]}{LISTEN}{body[at:]}{TELL % script}", encoding="utf-8")
    places = f"--user-data-dir={folder / 'profile'}", f"--log-net-log={log}"
    words = [FOUND, *FLAGS, *places, "--dump-dom", file.as_uri()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    told = re.search(r'<pre id="told-to-the-test">(.*?)</pre>', done.stdout, re.S)
    assert told, done.stderr[-2000:]
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    asked = re.findall(r'"initiator":"(?!not an origin)[^"]*".*?"url":"((?!file:|data:|blob:)[^"]+)"', log.read_text())
    return Opened(json.loads(unescape(told[1])), console, asked)
