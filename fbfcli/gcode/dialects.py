"""What a command that is not a plain motion means to Marlin, Klipper and RepRapFirmware.

Facts: Marlin's `src/gcode` (G92.cpp, M200-M205.cpp, G4.cpp, G10_G11.cpp), Klipper's `gcode_move.py` and `toolhead.py`,
RepRapFirmware's `GCodes2.cpp` and G-code dictionary.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

from fbfcli.errors import GcodeError
from fbfcli.gcode.in_order import AT_REST, NO_MOTION
from fbfcli.gcode.limit_commands import LIMIT_COMMANDS, Change
from fbfcli.units import MM_PER_INCH

AXES = "XYZE"
MS_PER_S = 1000.0
ABSURD = 1e12  # hosts "switch off" a limit with numbers up to about 1e9


class Kind(IntEnum):
    """What a line is to whoever writes the file again."""

    BLANK = 0  # no code
    MOTION = 1  # axis words, or a feed rate alone
    IN_ORDER = 2  # no motion of its own: stays where it is, in time
    LIMITS = 3  # changes acceleration, speed or jerk limits
    MODE = 4  # changes how later lines are read
    BARRIER = 5  # stops the machine, moves it by itself, or is not known
    RETRACT = 6  # firmware retraction: E alone, the position is kept
    PROGRESS = 7  # M73 and the slicers' time comments


@dataclass(frozen=True)
class Command:
    """A command and its parameters, capitals; `words` maps a letter or a Klipper key to its text."""

    name: str
    words: dict[str, str]

    def number(self, key: str) -> float | None:
        """Value of a parameter, None where it is absent. Raises GcodeError where it is not a number."""
        if key not in self.words:
            return None
        text = self.words[key].split(":")[0]  # RepRapFirmware lists one value per drive: E1000:1000
        if not _NUMBER.fullmatch(text) or abs(float(text)) > ABSURD:
            raise GcodeError(f"{self.name} has no sensible number after {key}", remedy="correct the line, or remove it")
        return float(text)

    def axes(self) -> dict[int, float]:
        """Values of X, Y, Z and E by axis number."""
        values = {k: self.number(axis) for k, axis in enumerate(AXES)}
        return {k: v for k, v in values.items() if v is not None}


@dataclass(frozen=True)
class Effect:
    """What one command does to the reading of the lines after it.

    wait     : dwell [s]
    stops    : the machine comes to rest
    lost     : X, Y and Z are not known afterwards
    homed    : axes that are homed (0, 1, 2)
    modes    : (mode, value): g91, m83 (bool), inch (bool), plane (17, 18, 19), speed_factor
    position : (axis, value): logical coordinate of an axis that is declared, not moved (G92); in the units in force
    limits   : changes of the planner's limits
    warning  : for people; said once
    """

    kind: Kind
    wait: float = 0.0
    stops: bool = False
    lost: bool = False
    homed: tuple[int, ...] = ()
    modes: tuple[tuple[str, float], ...] = ()
    position: tuple[tuple[int, float], ...] = ()
    limits: tuple[Change, ...] = ()
    warning: str = ""


EXPRESSION = "a line holds an expression or an unfilled placeholder { }: it passes as it is"

IN_ORDER = Effect(Kind.IN_ORDER)
WAITS = Effect(Kind.BARRIER, stops=True)
UNKNOWN = Effect(Kind.BARRIER, stops=True, lost=True)

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)")
_NUMBERED_LINE = re.compile(r"\s*N\d+\s*", re.IGNORECASE)
_CLASSIC = re.compile(r"\s*([A-Z])\s*(\d+(?:\.\d+)?)", re.IGNORECASE)
_WORD = re.compile(r"([A-Z])\s*([^A-Z]*)")
_KEY = re.compile(r"([A-Z_][A-Z0-9_]*)\s*=\s*(\"[^\"]*\"|\S*)", re.IGNORECASE)

_MODES: dict[str, tuple[tuple[str, float], ...]] = {
    "G90": (("g91", False),),
    "G91": (("g91", True),),
    "M82": (("m83", False),),
    "M83": (("m83", True),),
    "G17": (("plane", 17),),
    "G18": (("plane", 18),),
    "G19": (("plane", 19),),
    "G20": (("inch", True),),
    "G21": (("inch", False),),
}


def parse_command(text: str) -> Command:
    """The command on a line whose comments are removed; line number and checksum are ignored."""
    text = _NUMBERED_LINE.sub("", text, count=1) if text[:1] in "Nn \t" and _NUMBERED_LINE.match(text) else text
    classic = _CLASSIC.match(text)
    if not classic:
        name, rest = [*text.split(None, 1), "", ""][:2]
        return Command(name.upper(), {k.upper(): v.strip('"') for k, v in _KEY.findall(rest)})
    letter, number = classic[1].upper(), classic[2]
    rest = text[classic.end() :].split("*")[0].upper()
    words = {k: v.strip() for k, v in _WORD.findall(rest)}
    whole, _, part = number.partition(".")
    part = part.rstrip("0")
    return Command(letter + (whole.lstrip("0") or "0") + (part and "." + part), words)


@lru_cache(maxsize=4096)
def effect_of(text: str, firmware: str) -> Effect:
    """Effect of the command `text` (comments removed). Raises GcodeError, without the line's number."""
    command = parse_command(text)
    name = command.name
    if name in NO_MOTION or _not_of(name, firmware):
        return IN_ORDER
    if name in AT_REST:
        return WAITS
    if "{" in text:
        return Effect(Kind.BARRIER, stops=True, lost=True, warning=EXPRESSION)
    if name in ("G10", "G11"):
        return _firmware_retraction(command, firmware)
    if name == "G4":
        return Effect(Kind.BARRIER, wait=_dwell(command, firmware), stops=True)
    if name == "G28":
        homed = tuple(k for k in range(3) if AXES[k] in command.words) or (0, 1, 2)
        return Effect(Kind.BARRIER, stops=True, homed=homed)
    if name == "G92":
        return _declared_position(command, firmware)
    if name == "M220":
        return _speed_factor(command, firmware)
    if name in LIMIT_COMMANDS[firmware]:
        return _limits(command, firmware)
    if name in _MODES:
        return _mode(name, firmware)
    if name in ("G93", "G95", "G90.1"):
        raise GcodeError(f"{name} is not supported", remedy="use feed rates per minute (G94) and relative I, J (G91.1)")
    if name == "M73":
        return Effect(Kind.PROGRESS)
    if name == "M92":
        return Effect(Kind.IN_ORDER, warning="M92 changes the steps per mm: is the profile still right?")
    return UNKNOWN


def _not_of(name: str, firmware: str) -> bool:
    """A limits command of another firmware: this one answers "unknown command" and goes on."""
    return name not in LIMIT_COMMANDS[firmware] and any(name in commands for commands in LIMIT_COMMANDS.values())


def _firmware_retraction(command: Command, firmware: str) -> Effect:
    """G10 has three meanings: retract (bare, or Marlin's S1), temperature of a tool (S), offset of a tool (P X Y Z)."""
    words = command.words.keys()
    swap = words == {"S"} and firmware != "reprapfirmware" and command.number("S") in (0.0, 1.0)
    if command.name == "G11" or not words or swap:
        return Effect(Kind.RETRACT, stops=True)
    if words & {"S", "R"} and not words & set("XYZL"):
        return IN_ORDER
    return UNKNOWN


def _dwell(command: Command, firmware: str) -> float:
    """Seconds of G4: P in ms; Marlin and RepRapFirmware know S in s as well, and it wins."""
    milliseconds, seconds = command.number("P") or 0.0, command.number("S")
    if seconds is not None and firmware != "klipper":
        return seconds
    return milliseconds / MS_PER_S


def _declared_position(command: Command, firmware: str) -> Effect:
    """G92; bare, Klipper sets every axis to zero, the others do nothing. X, Y and Z can only be declared at rest: a
    compensated command is not where the file says while it moves."""
    axes = command.axes()
    if not axes and not command.words and firmware == "klipper":
        axes = dict.fromkeys(range(4), 0.0)
    return Effect(Kind.MODE, stops=any(axis < 3 for axis in axes), position=tuple(axes.items()))


def _speed_factor(command: Command, firmware: str) -> Effect:
    percent = command.number("S")
    if percent is None:
        return Effect(Kind.MODE, modes=(("speed_factor", 1.0),)) if firmware == "klipper" else IN_ORDER
    if percent <= 0:
        raise GcodeError("M220 needs a percentage above zero", remedy="M220 S100 is the programmed speed")
    return Effect(Kind.MODE, modes=(("speed_factor", percent / 100.0),))


def _limits(command: Command, firmware: str) -> Effect:
    changes = LIMIT_COMMANDS[firmware][command.name](command)
    return Effect(Kind.LIMITS, limits=changes) if changes else IN_ORDER


def _mode(name: str, firmware: str) -> Effect:
    """G90 and G91 set the extruder's mode too in Marlin; in Klipper G91 only overrides M82 (see `e_is_relative`)."""
    if name == "G20" and firmware == "klipper":
        raise GcodeError("Klipper refuses G20 (inches)", remedy="export the part in millimetres")
    modes = _MODES[name]
    if name in ("G90", "G91") and firmware == "marlin":
        modes += (("m83", name == "G91"),)
    return Effect(Kind.MODE, modes=modes)


def e_is_relative(g91: bool, m83: bool, firmware: str) -> bool:
    """Klipper's extruder is relative after G91 or M83; the others keep one mode for it."""
    return m83 or (g91 and firmware == "klipper")


def unit(inch: bool) -> float:
    """Millimetres per unit of length."""
    return MM_PER_INCH if inch else 1.0
