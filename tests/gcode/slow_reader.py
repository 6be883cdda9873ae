"""An independent interpreter: one line at a time, one word at a time. Slow, plain, and only for comparison."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

WORD = re.compile(r"([A-Z])\s*([-+]?\d*\.?\d*)")
ACCELERATION, TRAVEL, RETRACT = "acceleration", "travel_acceleration", "retract_acceleration"


@dataclass
class SlowReader:
    """State of the machine; `steps` gets (line, dx, dy, dz, de) of every line that moves."""

    firmware: str
    at: dict[str, float] = field(default_factory=lambda: dict.fromkeys("XYZE", 0.0))
    moved: dict[str, float] = field(default_factory=lambda: dict.fromkeys("XYZE", 0.0))
    absolute: bool = True
    absolute_e: bool = True
    inch: bool = False
    mode: str = "G1"
    feed: float = 1500.0
    limits: dict[str, float] = field(default_factory=dict)
    steps: list[tuple[int, float, float, float, float]] = field(default_factory=list)
    feeds: list[float] = field(default_factory=list)

    def read(self, text: str) -> None:
        for number, line in enumerate(text.split("\n")):
            code = re.sub(r"\(.*?\)", " ", line.split(";")[0]).strip().upper()
            code = re.sub(r"^N\d+\s*", "", code).split("*")[0].strip()
            if code and "{" not in code:
                self.line(number, code)

    def line(self, number: int, code: str) -> None:
        head = re.match(r"([GMT])\s*(\d+)", code)
        if not head and not re.match(r"[XYZEF]\s*[-+.\d]", code):
            if code.startswith("SET_VELOCITY_LIMIT") and self.firmware == "klipper":
                self.velocity_limit(code)
            return
        name = head[1] + str(int(head[2])) if head else self.mode
        words = {k: float(v) for k, v in WORD.findall(code[head.end() :] if head else code) if v.strip("+-.")}
        if name in ("G0", "G1", "G2", "G3"):
            self.mode = name
            self.move(number, words)
        elif name in ("G90", "G91"):
            self.absolute = name == "G90"
            if self.firmware == "marlin":
                self.absolute_e = self.absolute
        elif name in ("M82", "M83"):
            self.absolute_e = name == "M82"
        elif name in ("G20", "G21"):
            self.inch = name == "G20"
        elif name == "G92":
            self.at.update({k: v * self.unit for k, v in words.items() if k in "XYZE"})
        elif name == "G28":
            self.at.update(dict.fromkeys([k for k in "XYZ" if re.search(k, code[3:])] or "XYZ", 0.0))
        elif name == "M204":
            self.m204(words)
        elif name == "M205" and self.firmware != "klipper":
            self.limits.update({f"jerk{k}": v for k, v in words.items() if k in "XYZE"})
        if name == "G17" and " G90" in code:
            self.absolute = True  # several commands on a line

    @property
    def unit(self) -> float:
        return 25.4 if self.inch else 1.0

    def move(self, number: int, words: dict[str, float]) -> None:
        before = dict(self.at)
        for k in "XYZE":
            if k in words:
                e_absolute = self.absolute_e and (self.absolute or self.firmware != "klipper")
                absolute = e_absolute if k == "E" else self.absolute
                self.at[k] = words[k] * self.unit + (0.0 if absolute else self.at[k])
        self.feed = words.get("F", self.feed / self.unit) * self.unit
        step = [self.at[k] - before[k] for k in "XYZE"]
        circle = self.mode in ("G2", "G3") and words.keys() & set("XYZIJR")
        if any(abs(d) > 1e-9 for d in step) or circle:
            self.steps.append((number, *step))
            self.feeds.append(self.feed / 60.0)
        for k, d in zip("XYZE", step, strict=True):
            self.moved[k] += d

    def m204(self, words: dict[str, float]) -> None:
        if self.firmware == "klipper":
            if "S" in words:
                self.limits[ACCELERATION] = words["S"]
            elif "P" in words and "T" in words:
                self.limits[ACCELERATION] = min(words["P"], words["T"])
            return
        if "S" in words:
            self.limits[ACCELERATION] = self.limits[TRAVEL] = words["S"]
        for letter, name in (("P", ACCELERATION), ("R", RETRACT), ("T", TRAVEL)):
            if letter in words and not (letter == "R" and self.firmware == "reprapfirmware"):
                self.limits[name] = words[letter]

    def velocity_limit(self, code: str) -> None:
        names = {"ACCEL": ACCELERATION, "SQUARE_CORNER_VELOCITY": "square_corner_velocity", "VELOCITY": "velocity"}
        for key, value in re.findall(r"(\w+)=(\S+)", code):
            if key in names:
                self.limits[names[key]] = float(value)
