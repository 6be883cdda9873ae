"""What the lines that are not plain motion do: modes in force, dwells, limits, as arrays over lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fbfcli.errors import GcodeError
from fbfcli.gcode import scan
from fbfcli.gcode.dialects import Effect, Kind, e_is_relative, effect_of, unit
from fbfcli.gcode.limit_commands import Change, changed
from fbfcli.gcode.scan import Lines
from fbfcli.gcode.state import State
from fbfcli.printer import Limits

TIME_COMMENTS = (b";TIME:", b";TIME_ELAPSED:", b"; estimated printing time", b"; total estimated time", b";PRINT.TIME:")
_COMMENT = re.compile(rb";[^\n]*|\([^)\n]*\)?")
Effects = Mapping[int, tuple[Effect, ...]]


@dataclass(frozen=True)
class Modal:
    """Modes of n lines; a mode is the one in force after the line.

    kind                           : ndarray of uint8, shape (n,)  a Kind for each line
    wait                           : ndarray, shape (n,)           dwell [s]
    xy_relative, e_relative, inch  : ndarray of bool, shape (n,)
    plane                          : ndarray of uint8, shape (n,)  17, 18 or 19
    speed_factor                   : ndarray, shape (n,)           M220
    in_force                       : ndarray of int, shape (n,)    index into `limits`
    limits                         : tuple of Limits               every set met so far
    stops, lost                    : ndarray of int                lines where the machine rests; where it gets lost
    declared                       : tuple of (line, axis, value)  G92 [mm]
    homed                          : tuple of (line, axis)         G28
    warnings                       : tuple of str                  new ones
    """

    kind: np.ndarray
    wait: np.ndarray
    xy_relative: np.ndarray
    e_relative: np.ndarray
    inch: np.ndarray
    plane: np.ndarray
    speed_factor: np.ndarray
    in_force: np.ndarray
    limits: tuple[Limits, ...]
    stops: np.ndarray
    lost: np.ndarray
    declared: tuple[tuple[int, int, float], ...]
    homed: tuple[tuple[int, int], ...]
    warnings: tuple[str, ...]
    last: Mapping[str, float]  # the value of every mode after the last line


def code_of(raw: bytes) -> str:
    """The part of a line that is not comment."""
    if b"(" in raw:
        raw = _COMMENT.sub(b" ", raw)
    return raw.partition(b";")[0].decode("latin-1").strip()


def modal(lines: Lines, odd: Effects, state: State, firmware: str) -> Modal:
    """Modes of `lines`; `odd` holds the effects of lines with several commands. Raises GcodeError."""
    n = len(lines)
    journal = _Journal(n, state, firmware)
    kind = np.full(n, Kind.MOTION, np.uint8)
    kind[lines.code == scan.BLANK] = Kind.BLANK
    for i, effect in _effects(lines, odd, firmware):
        if lines.code[i] == scan.OTHER:
            kind[i] = effect.kind
        journal.note(i, effect)
    kind[_time_comments(lines)] = Kind.PROGRESS
    history, table = journal.history, journal.table
    return Modal(
        kind=kind,
        wait=journal.wait,
        xy_relative=_steps(n, history["g91"], bool),
        e_relative=_steps(n, history["relative_e"], bool),
        inch=_steps(n, history["inch"], bool),
        plane=_steps(n, history["plane"], np.uint8),
        speed_factor=_steps(n, history["speed_factor"], float),
        in_force=_steps(n, table.history, np.intp),
        limits=tuple(table.known),
        stops=np.array(journal.stops, np.intp),
        lost=np.array(journal.lost, np.intp),
        declared=tuple(journal.declared),
        homed=tuple(journal.homed),
        warnings=tuple(w for w in dict.fromkeys(journal.warnings) if w not in state.warned),
        last={**journal.modes, "in_force": table.history[-1][1]},
    )


class _Journal:
    """What the commands of a block did, in order."""

    def __init__(self, n: int, state: State, firmware: str):
        self.modes: dict[str, float] = {"g91": state.g91, "m83": state.m83, "inch": state.inch, "plane": state.plane,
                                        "speed_factor": state.speed_factor}  # fmt: skip
        self.history: dict[str, list[tuple[int, float]]] = {name: [(0, value)] for name, value in self.modes.items()}
        self.history["relative_e"] = [(0, e_is_relative(state.g91, state.m83, firmware))]
        self.table = _LimitsTable(state)
        self.wait = np.zeros(n)
        self.stops: list[int] = []
        self.lost: list[int] = []
        self.declared: list[tuple[int, int, float]] = []
        self.homed: list[tuple[int, int]] = []
        self.warnings: list[str] = []
        self._firmware = firmware

    def note(self, i: int, effect: Effect) -> None:
        """Line i has this effect."""
        if effect.limits:
            self.table.change(i, effect.limits)
            return
        if effect.stops:
            self.stops.append(i)
            self.wait[i] = effect.wait
        if effect.lost:
            self.lost.append(i)
        if effect.warning:
            self.warnings.append(effect.warning)
        self.homed.extend((i, axis) for axis in effect.homed)
        scale = unit(bool(self.modes["inch"]))
        self.declared.extend((i, axis, value * scale) for axis, value in effect.position)
        for name, value in effect.modes:
            self.modes[name] = value
            self.history[name].append((i, value))
            relative = e_is_relative(bool(self.modes["g91"]), bool(self.modes["m83"]), self._firmware)
            self.history["relative_e"].append((i, relative))


def _effects(lines: Lines, odd: Effects, firmware: str) -> Iterable[tuple[int, Effect]]:
    """(line, effect) of every line that is a command, in order."""
    at = np.flatnonzero(lines.code == scan.OTHER).tolist()
    if odd:
        at = sorted({*at, *odd})
    for i in at:
        if i in odd:
            yield from ((i, effect) for effect in odd[i])
            continue
        raw = lines.raw(i)
        try:
            yield i, effect_of(code_of(raw), firmware)
        except GcodeError as error:
            raise at_line(error, lines, i) from None


def at_line(error: GcodeError, lines: Lines, i: int) -> GcodeError:
    """The same error with the place of line i of `lines`."""
    text = lines.raw(i).decode("utf-8", "replace")
    return GcodeError(error.why, line=lines.first + i + 1, text=text, remedy=error.remedy)


class _LimitsTable:
    """Sets of limits met so far, each once. Files repeat a few of them tens of thousands of times."""

    def __init__(self, state: State):
        self.known: dict[Limits, int] = {limits: k for k, limits in enumerate(state.limits)}
        self.history: list[tuple[int, float]] = [(0, state.in_force)]
        self._seen: dict[tuple[int, tuple[Change, ...]], int] = {}
        self._present = state.in_force
        self._table = list(state.limits)

    def change(self, line: int, changes: tuple[Change, ...]) -> None:
        key = (self._present, changes)
        if key not in self._seen:
            limits = changed(self._table[self._present], changes)
            self._seen[key] = self.known.setdefault(limits, len(self.known))
            if len(self.known) > len(self._table):
                self._table.append(limits)
        self._present = self._seen[key]
        self.history.append((line, self._present))


def _steps(n: int, history: Sequence[tuple[int, float]], dtype: type) -> np.ndarray:
    """Piecewise constant array, shape (n,): from each line of `history` on, its value."""
    if len(history) == 1:
        return np.full(n, history[0][1], dtype)
    line, value = zip(*history, strict=True)
    return np.repeat(np.array(value, dtype), np.diff(line, append=n))


def _time_comments(lines: Lines) -> list[int]:
    """Lines that hold a slicer's time comment."""
    found = []
    for prefix in TIME_COMMENTS:
        at = lines.text.find(prefix)
        while at >= 0:
            i = int(np.searchsorted(lines.begin, at, side="right")) - 1
            if lines.begin[i] == at:
                found.append(i)
            at = lines.text.find(prefix, at + 1)
    return found
