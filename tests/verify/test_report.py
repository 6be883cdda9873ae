"""The report: one file, everything in it, and a page that works."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import browser
import numpy as np
import pytest
from trace_cases import LAYER, pieces, square

from fbfcli.plant.model import plant_of
from fbfcli.printer import ModalModel, Mode
from fbfcli.verify.close_ups import Window
from fbfcli.verify.envelope import STEPS, Envelope
from fbfcli.verify.report import html
from fbfcli.verify.subject import Card, Ceilings, Sheet, Spans, Subject
from fbfcli.verify.traces import POINTS, Kept, Traces

LAYERS = 6
MOST_BYTES = 15e6
PLANT = plant_of(ModalModel((Mode(40.0, 0.1),)), 1e-3, "x")
ODD = '</script><b>part & "1"</b> @@DATA@@.gcode'


def kept(layers: int = LAYERS) -> Kept:
    traces = Traces(40_000, 3)
    runs = (pieces(square(layers, amplitude, 1), [LAYER + 7]) for amplitude in (0.3, 0.02))
    for before, after in zip(*runs, strict=True):
        traces.add("as sliced", before)
        traces.add("lpfbs", after)
    traces.segments("lpfbs", np.linspace(0, 4, 300))
    traces.load("lpfbs", np.linspace(0, 4, 50), np.full((50, 2), 0.4), ("x", "y"))
    return traces.kept()


def subject() -> Subject:
    gap = np.append(np.full(LAYERS - 1, 4.0), np.nan)
    errors = {"as sliced": Spans(np.full(LAYERS, 80.0), np.full(LAYERS, 300.0)), "lpfbs": Spans(gap, 5 * gap)}
    return Subject(
        title=ODD, lead="Predicted.", warnings=("a <warning>",), cards=(Card("RMS", "4.0 µm", "as sliced 80.0 µm"),),
        sheets=(Sheet("Methods", "Figures.", ("method", "RMS [µm]"), (("as sliced", "80.0"), ("lpfbs", "4.0"))),
                Sheet("Mismatch", "More.", ("method", "−10 %"), (("lpfbs", "9.0"),))),
        by_layer=errors, by_feature={name: Spans(one.rms[:2], one.largest[:2]) for name, one in errors.items()},
        features=("wall", "infill"), plants=((PLANT.b, PLANT.a), (PLANT.b, PLANT.a)),
        ceilings=Ceilings((400.0, 400.0), (np.inf, 2e4), 1000.0), settings=(("printer", "square"),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def page() -> str:
    return html(kept(), subject())


def data(page: str) -> dict:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    return json.loads(found[1], parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_the_page_refers_to_nothing_outside_itself(page):
    frame = re.sub(r"(?s)<script.*?</script>", "", page)
    assert not re.findall(r"(?i)\b(?:src|href|srcset|data|action|poster)\s*=", frame)
    assert not re.findall(r"(?i)url\(|@import|https?://|//cdn", frame)
    assert not re.findall(r"(?i)<script[^>]+src|<link|<iframe|<object|<embed", frame + page[:5000])
    assert "default-src 'none'" in page


def test_the_page_is_small_and_its_numbers_are_json(page):
    assert len(page.encode()) < MOST_BYTES
    numbers = data(page)
    assert numbers["methods"] == ["as sliced", "lpfbs"] and len(numbers["layers"]) == LAYERS
    assert numbers["byLayer"]["lpfbs"]["rms"][-1] is None and numbers["ceilings"]["acceleration"] == [None, 20000.0]


def test_what_users_name_stays_text(page):
    frame = re.sub(r"(?s)<script.*?</script>", "", page)
    assert "<b>part" not in frame and "&lt;b&gt;part" in frame and "@@DATA@@" in frame
    assert "a &lt;warning&gt;" in frame


def test_a_full_budget_fits_the_page():
    """All points there may be, the corners of eight methods, and nothing that packs well."""
    rng = np.random.default_rng(3)
    traces = Traces()
    for k in range(8):
        traces.add(f"method {k}", square(6, 5.0, k))
    found = traces.kept()
    path = next(iter(found.layers[0].nozzle.values()))
    x, error = rng.uniform(0, 300, (POINTS, 2)), rng.uniform(0, 1, POINTS)
    full = replace(path, x=x, error=error, line=7 * np.arange(POINTS), new=np.zeros(POINTS, dtype=bool))
    curve = Envelope(0.01, np.arange(STEPS) / 7, *(rng.uniform(0, 1e4, (STEPS, 4)) for _ in range(3)))
    curves = dict.fromkeys(("error", "moves", "load", "segments"), curve)
    methods = {name: replace(one, **curves) for name, one in found.methods.items()}
    own = found.corners[0].windows["method 0"]
    longest = (2 * max(len(window) for corner in found.corners for window in corner.windows.values()),)
    window = Window(*(rng.uniform(0, 100, longest + column.shape[1:]) for column in vars(own).values()))
    corners = tuple(replace(each, windows=dict.fromkeys(each.windows, window)) for each in found.corners)
    layers = (replace(found.layers[0], nozzle={"method 0": full}),)
    size = len(html(replace(found, layers=layers, methods=methods, corners=corners), subject()).encode())
    assert 10e6 < size < MOST_BYTES


def test_a_print_without_anything_is_a_page_without_pictures():
    assert "Settings" in html(Traces().kept(), Subject("empty", "Nothing moves."))


SCRIPT = """
const plan = document.getElementById("plan"), slider = document.getElementById("layer");
const wait = () => new Promise(done => setTimeout(done, 300));
const shown = () => JSON.stringify(plan.data.map(trace => trace.x.slice(0, 400)));
const range = () => [...plan.layout.xaxis.range, ...plan.layout.yaxis.range];
await wait();
told.ready = document.body.dataset.ready;
const plots = [...document.querySelectorAll(".plot")];
told.drawn = plots.filter(each => each.querySelector("svg.main-svg path")).map(each => each.id);
told.traces = plan.data.map(trace => trace.name);
told.buttons = [...new Set([...document.querySelectorAll(".modebar-btn")].map(each => each.dataset.title))];
told.layers = Number(slider.max) + 1;
told.before = shown();
told.label = document.getElementById("layer-told").textContent;
slider.value = 0;
slider.dispatchEvent(new Event("input"));
await wait();
told.after = shown();
told.labelAfter = document.getElementById("layer-told").textContent;
told.whole = range();
const box = plan.querySelector(".nsewdrag").getBoundingClientRect();
const mouse = (kind, at, to) => to.dispatchEvent(new MouseEvent(kind, { bubbles: true, view: window, buttons: 1,
  clientX: box.left + at * box.width, clientY: box.top + at * box.height }));
mouse("mousedown", 0.3, plan.querySelector(".nsewdrag"));
mouse("mousemove", 0.5, document);
mouse("mousemove", 0.6, document);
mouse("mouseup", 0.6, document);
await wait();
told.zoomed = range();
slider.value = 1;
slider.dispatchEvent(new Event("input"));
await wait();
told.kept = range();
document.querySelector("#chips button").click();
await wait();
told.jumped = range();
told.note = document.getElementById("plan-note").textContent;
told.on = document.querySelector("#chips button.on").textContent;
const times = document.getElementById("times"), far = () => Math.max(...plan.data[1].y.map(y => Math.abs(y - 110)));
document.getElementById("all").click();
await wait();
told.far = far();
times.value = "20";
times.dispatchEvent(new Event("change"));
await wait();
told.farther = far();
times.value = "1";
times.dispatchEvent(new Event("change"));
const choice = document.getElementById("colour");
choice.value = "as sliced";
choice.dispatchEvent(new Event("change"));
await wait();
told.classes = plan.data.map(trace => trace.name);
document.getElementById("all").click();
await wait();
told.again = range();
"""


@pytest.mark.browser
@pytest.mark.skipif(not browser.FOUND, reason="no Chromium here")
def test_the_page_works_in_a_browser(page, tmp_path):
    """No requests, no complaints; layers change, dragging zooms and stays, a chip leads to its corner."""
    seen = browser.opened(page, SCRIPT, tmp_path)
    told = seen.told
    assert told["complaints"] == [] and seen.console == []
    assert told["loaded"] == [] and seen.asked == []
    assert told["ready"] == "yes" and told["layers"] == LAYERS
    pictures = {"plan", "corner", "errors", "layers", "features", "speed", "acceleration", "load", "segments"}
    assert pictures <= set(told["drawn"])
    assert told["traces"] == ["desired path", "as sliced", "lpfbs"]
    assert told["buttons"] == ["Zoom", "Pan", "Reset axes", "Download plot as a PNG"]  # and none that sends it away
    assert told["before"] != told["after"] and told["label"] != told["labelAfter"]
    assert told["labelAfter"].startswith(f"1 of {LAYERS} at Z 0.20 mm")
    width = [span[1] - span[0] for span in (told["whole"], told["zoomed"], told["jumped"], told["again"])]
    assert width[1] < 0.5 * width[0] and told["kept"] == told["zoomed"]
    corner = data(page)["corners"][0]
    assert width[2] < 0.9 * width[0] and told["jumped"] != told["zoomed"]
    assert abs(sum(told["jumped"][:2]) / 2 - corner["at"][0]) < 0.1
    assert abs(sum(told["jumped"][2:]) / 2 - corner["at"][1]) < 0.1
    assert f"Line {corner['line']} " in told["note"] and told["on"] == str(round(corner["error"]))
    assert told["farther"] - 10 == pytest.approx(20 * (told["far"] - 10), rel=0.05)  # off the side at 120 mm
    assert told["classes"][1:] == ["≤ 10 µm", "≤ 25 µm", "≤ 50 µm", "≤ 100 µm", "≤ 200 µm", "> 200 µm"]
    assert width[3] == pytest.approx(width[0], rel=0.15)


@pytest.mark.browser
@pytest.mark.skipif(not browser.FOUND, reason="no Chromium here")
def test_the_test_sees_requests_and_complaints(tmp_path):
    bad = (
        '<html><head></head><body><img src="http://example.invalid/x.png"><script>nothing.there</script></body></html>'
    )
    seen = browser.opened(bad, "", tmp_path)
    assert seen.asked == ["http://example.invalid/x.png"] == seen.told["loaded"]
    assert any("nothing is not defined" in words for words in seen.told["complaints"]) and seen.console
