"""Prove that a compensated file is still the print it was made from, from the bytes of both files alone.

Both files are read by `scan` and `interpret` and executed by the planner model; nothing that the pipeline says of its
own work is believed. Each law is a function
that gives its failures.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.interpret import Block, initial_state, interpret
from fbfcli.gcode.motion import DEFAULT_FEED
from fbfcli.gcode.scan import scan
from fbfcli.gcode.stamp import HEAD_BYTES, is_stamped
from fbfcli.motion.moves import EPS_MM, E, Moves, Z
from fbfcli.motion.profile import Profile
from fbfcli.motion.timing import executed
from fbfcli.printer import Limits, Printer

EPS_E = 1e-4  # mm of filament over a file
EPS_XY = 1.5e-5  # mm: one unit of the last decimal, and rounding of sums
MARLIN_STEPS = 6
REST = 10.0  # mm/s: no faster than this, X and Y arrive at a place where they are to rest
SPEED_ROOM = 1.02  # of the highest command speed: time is fed back by speed
SWITCHES = ("xy_relative", "e_relative", "inch", "speed_factor")
MOST_TOLD = 3  # places that a failure quotes

Pairs = list[tuple[int, int]]  # lines of the input and of the output that are the same

DEFERRED = b"; fbf: "
OURS = re.compile(rb"G1(?: [XYZEF]-?\d{1,7}(?:\.\d{1,5})?)+")
ABSURD = re.compile(rb"^[ \t]*G[0-3][^;(\n]*?(?:nan|inf|\d{8}|\d[eE][-+]\d)", re.IGNORECASE | re.MULTILINE)
_ADDED = re.compile(rb"; fbf |M593|M493|SET_INPUT_SHAPER|M205 B|M20[1345] |M566 |SET_VELOCITY_LIMIT ")
_NUMBERED = re.compile(rb"^\s*[Nn]\s*\d+\s*")
_CHECKSUM = re.compile(rb"\s*\*\d+[ \t]*(?=\r?$|;)")
_FIGURES = re.compile(rb"(?:[\d.]+[ \t]*[dhms]?[ \t]*)+(?:\r?$)?")
_RESET = re.compile(rb"^(\s*[Gg]92\s+[Ee])\s*[-+.\d]+.*", re.DOTALL)


@dataclass(frozen=True)
class Reading:
    """One file as its bytes say: lines, motion, and what the planner makes of it."""

    text: bytes
    block: Block
    firmware: str

    @classmethod
    def of(cls, text: bytes, printer: Printer) -> Reading:
        return cls(text, interpret(scan(text), initial_state(printer), printer)[0], printer.firmware)

    @cached_property
    def rows(self) -> list[bytes]:
        """The lines, without their newline."""
        return [self.block.lines.raw(i).removesuffix(b"\n") for i in range(len(self.block.lines))]

    @property
    def moves(self) -> Moves:
        return self.block.moves

    @cached_property
    def plan(self) -> Profile:
        return executed(self.moves, self.firmware)

    @cached_property
    def end(self) -> np.ndarray:
        """Where the machine is after each move, and before the first (last row), shape (m + 1, 4)."""
        before = self.moves.start[:1] if len(self.moves) else np.zeros((1, 4))
        return np.vstack([self.moves.start + self.moves.delta, before])

    def position(self, line: np.ndarray) -> np.ndarray:
        """Where the machine is before each line, shape (n, 4)."""
        return self.end[np.searchsorted(self.moves.line, line) - 1]

    def limits(self, line: int) -> Limits:
        """What is in force after a line."""
        return self.moves.limits[int(self.block.state[line])]

    @property
    def seconds(self) -> float:
        return float(self.plan.duration.sum() + self.block.wait.sum())


def check(original: bytes, written: bytes, printer: Printer) -> list[str]:
    """Failures of `written`, which was made from `original` for `printer`; empty for a good print."""
    before, after = Reading.of(original, printer), Reading.of(written, printer)
    pairs, failures = matched(before, after)
    for law in LAWS:
        failures += law(before, after, pairs, printer)
    return failures


def matched(before: Reading, after: Reading) -> tuple[Pairs, list[str]]:
    """Where each line without motion of the input stands in the output, in order; what is lost, or not asked for."""
    kind = before.block.kind
    keys = [_key(row) for row in after.rows]
    index: dict[bytes, list[int]] = {}
    for j, key in enumerate(keys):
        index.setdefault(key, []).append(j)
    pairs, lost, at = [], [], 0
    for i in np.flatnonzero(kind != Kind.MOTION).tolist():
        places = index.get(_key(before.rows[i]), [])
        k = bisect_left(places, at)
        if k == len(places):
            lost.append(i)
            continue
        pairs.append((i, places[k]))
        at = places[k] + 1
    failures = _told(f"{len(lost)} lines of the input are lost", before, lost)
    own = {j for _, j in pairs}
    others = [j for j in np.flatnonzero(after.block.kind != Kind.MOTION).tolist() if j not in own]
    added = [j for j in others if not _ADDED.match(after.rows[j])]
    return pairs, failures + _told(f"{len(added)} lines come from nowhere", after, added)


def _key(row: bytes) -> bytes:
    """A line without what may be changed of it: comment mark, number and checksum, times, E of a G92."""
    row = row.removeprefix(DEFERRED)
    if _NUMBERED.match(row):
        row = _CHECKSUM.sub(b"", _NUMBERED.sub(b"", row))
    if (row[:1] == b";" and b"ime" in row.lower()) or row.lstrip()[:3].upper() == b"M73":
        return _FIGURES.sub(b"#", row).rstrip()
    return _RESET.sub(rb"\1#", row)


def stamped(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    failures = [] if is_stamped(after.text[:HEAD_BYTES]) else ["no stamp"]
    kept = before.block.kind[0] == Kind.MOTION or _key(before.rows[0]) == _key(after.rows[0])
    return failures + ([] if kept else ["line 1 has changed"])


def no_absurd_word(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Every motion line is one of the input's, with an F at most put before it, or a plain G1."""
    known = {_key(row) for row in before.rows}
    strange = [j for j in np.flatnonzero(after.block.kind == Kind.MOTION).tolist()
               if not OURS.fullmatch(after.rows[j]) and _key(after.rows[j]) not in known
               and after.rows[j].partition(b" ")[2] not in known]
    failures = _told(f"{len(strange)} motion lines are neither the input's nor plain", after, strange)
    absurd = ABSURD.search(after.text)
    return failures + ([f"absurd word in {absurd[0][:60]!r}"] if absurd and not ABSURD.search(before.text) else [])


def same_totals(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """E over the file, and where it ends."""
    e_in, e_out = (float(reading.moves.delta[:, E].sum()) for reading in (before, after))
    failures = [] if abs(e_in - e_out) <= EPS_E else [f"E total {e_out:.5f} mm instead of {e_in:.5f}"]
    off = np.abs(before.end[len(before.moves) - 1, :3] - after.end[len(after.moves) - 1, :3]).max()
    return failures + ([f"the print ends {off:.5f} mm from where it should"] if off > EPS_XY else [])


def same_at_barriers(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Where anything may happen, the machine is where the input has it, under the input's limits, modes and F."""
    barrier = [(i, j) for i, j in pairs if before.block.kind[i] in (Kind.BARRIER, Kind.RETRACT)]
    if not barrier:
        return []
    i, j = np.array(barrier).T
    off = np.abs(before.position(i) - after.position(j))
    failures = _told("not in place", after, j[(off[:, :3] > EPS_XY).any(axis=1)].tolist())
    failures += _told("E is off", after, j[off[:, E] > EPS_E].tolist())
    stops = [(i, j) for i, j in barrier if before.block.kind[i] == Kind.BARRIER]
    limits = [j for i, j in stops if not _same_limits(before.limits(i), after.limits(j))]
    modes = [j for i, j in stops if not _same_modes(before.block, i, after.block, j)]
    return failures + _told("other limits in force", after, limits) + _told("other modes in force", after, modes)


def same_at_end(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Limits and modes after the last line."""
    failures = [] if _same_limits(before.limits(-1), after.limits(-1)) else [
        f"limits at the end are {after.limits(-1)} instead of {before.limits(-1)}"]
    return failures + ([] if _same_modes(before.block, -1, after.block, -1) else ["other modes in force at the end"])


def _same_limits(a: Limits, b: Limits) -> bool:
    x, y = (np.hstack([np.atleast_1d(getattr(one, f.name)) for f in fields(Limits)]) for one in (a, b))
    return bool(np.allclose(x, y, rtol=1e-5, atol=1e-5, equal_nan=True))


def _same_modes(a: Block, i: int, b: Block, j: int) -> bool:
    same = all(getattr(a, name)[i] == getattr(b, name)[j] for name in SWITCHES)
    x, y = _numbers(a, i), _numbers(b, j)
    return same and bool(np.allclose(x, y, rtol=1e-6, atol=EPS_E, equal_nan=True))


def _numbers(block: Block, k: int) -> np.ndarray:
    """F (that of power-on where none was given), E and the offsets in force after line k."""
    feed = DEFAULT_FEED if np.isnan(block.feed[k]) else block.feed[k]
    return np.array([feed, block.e_logical[k], *block.offset[k]])


def no_zero_length(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """A firmware drops a segment that goes nowhere, and its time."""
    ours = _ours(before, after)
    still = np.abs(after.moves.delta[:, :3]).max(axis=1, initial=0.0) < EPS_MM
    moved = np.zeros(len(after.rows), bool)
    moved[after.moves.line[~still]] = True
    return _told("segments without length", after, np.flatnonzero(ours & ~moved).tolist())


def none_lost_for_steps(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Marlin drops a segment of fewer than MIN_STEPS_PER_SEGMENT steps. One between moves of Z or E alone is a move of
    the input's that is as short."""
    if printer.firmware != "marlin":
        return []
    steps = np.array([axis.steps_per_mm for axis in printer.axes[:2]])
    most = (np.abs(after.moves.delta[:, :2]) * steps).max(axis=1, initial=0.0)
    still = np.concatenate([[True], most == 0.0, [True]])
    lost = (most < MARLIN_STEPS - 1e-6) & ~(still[:-2] & still[2:]) & _ours(before, after)[after.moves.line]
    return _told("segments that Marlin drops", after, after.moves.line[lost].tolist())


def _ours(before: Reading, after: Reading) -> np.ndarray:
    """Lines of the output that fbf wrote as segments: X, Y and F, and not in the input; bool, shape (n,)."""
    words = after.block.lines.words
    ours = ~np.isnan(words["X"]) & ~np.isnan(words["Y"]) & ~np.isnan(words["F"]) & (after.block.kind == Kind.MOTION)
    given = set(before.rows)
    for j in np.flatnonzero(ours).tolist():
        ours[j] = after.rows[j] not in given
    return ours


def same_standing_moves(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Moves of Z or E alone are the input's, one by one, and find X and Y at rest in the input's place."""
    (_, given), (j, kept) = _standing(before), _standing(after)
    if len(given) != len(kept):
        return [f"{len(kept)} moves of Z or E alone instead of {len(given)}"]
    wrong = (np.abs(given[:, :5] - kept[:, :5]) > EPS_XY).any(axis=1) | (np.abs(given[:, 5] - kept[:, 5]) > EPS_E)
    failures = _told("a move of Z or E alone is not the input's", after, after.moves.line[j[wrong]].tolist())
    arrives = np.append(after.plan.v_end, 0.0)[j - 1] * (np.append(after.moves.delta[:, 0], 0.0)[j - 1] != 0.0)
    return failures + _told("X is not at rest", after, after.moves.line[j[arrives > REST]].tolist())


def _standing(reading: Reading) -> tuple[np.ndarray, np.ndarray]:
    """Moves with X and Y still: their indices, and start X Y Z, displacement of Z, E, and start E, shape (k, 6)."""
    moves = reading.moves
    at = np.flatnonzero((np.abs(moves.delta[:, :2]) <= EPS_MM).all(axis=1))
    return at, np.column_stack([moves.start[at, :3], moves.delta[at, Z], moves.delta[at, E], moves.start[at, E]])


def stays_within_limits(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """What fbf commands is what the machine may be commanded."""
    moves = after.moves
    ours = _ours(before, after)[moves.line]
    failures = []
    for k, axis in enumerate(printer.axes[:2]):
        end = after.end[:-1, k]
        out = ours & ((end < axis.travel[0] - EPS_XY) | (end > axis.travel[1] + EPS_XY))
        failures += _told(f"{axis.name} outside its travel", after, moves.line[out].tolist())
        speed = np.abs(moves.delta[:, k]) / np.maximum(after.plan.duration, 1e-12)
        fast = ours & (speed > SPEED_ROOM * axis.command_velocity)
        failures += _told(f"{axis.name} above its command speed", after, moves.line[fast].tolist())
    return failures


def no_thicker_line(before: Reading, after: Reading, pairs: Pairs, printer: Printer) -> list[str]:
    """Klipper's max_extrude_cross_section, klippy/kinematics/extruder.py check_move: aborts the print."""
    if printer.firmware != "klipper":
        return []
    (_, was), (at, found) = (_too_thick(reading.moves, printer) for reading in (before, after))
    return [] if found <= was else _told("extrudes more than Klipper allows", after, at.tolist())


def _too_thick(moves: Moves, printer: Printer) -> tuple[np.ndarray, int]:
    """Lines that Klipper would refuse, and their number."""
    ratio = printer.max_extrude_cross_section / (np.pi * (printer.filament_diameter / 2) ** 2)
    travels = (np.abs(moves.delta[:, :2]) > EPS_MM).any(axis=1)
    e = moves.delta[:, E]
    bad = travels & (e > ratio * moves.distance) & (e > ratio * printer.nozzle_diameter)
    return moves.line[bad], int(bad.sum())


def _told(words: str, reading: Reading, lines: list[int]) -> list[str]:
    if not lines:
        return []
    quoted = ", ".join(f"line {i + 1} {reading.rows[i][:60]!r}" for i in lines[:MOST_TOLD])
    return [f"{words}: {quoted}{f' and {len(lines) - MOST_TOLD} more' if len(lines) > MOST_TOLD else ''}"]


LAWS = (stamped, no_absurd_word, same_totals, same_at_barriers, same_at_end, no_zero_length, none_lost_for_steps,
        same_standing_moves, stays_within_limits, no_thicker_line)  # fmt: skip
