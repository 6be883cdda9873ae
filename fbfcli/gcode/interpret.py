"""Lines of G-code to straight moves and to what each line means, with the modal state carried from chunk to chunk.

Plain motion is array code. Lines that only a grammar can read (several commands, a sign in the wrong
place) go through pygcode here, or are refused with their place.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import GcodeError
from fbfcli.gcode.coordinates import Track, track
from fbfcli.gcode.dialects import UNKNOWN, Effect, Kind, effect_of
from fbfcli.gcode.modal import Modal, at_line, code_of, modal
from fbfcli.gcode.motion import Feed, feeds, motion_modes, moves_of, refuse_absurd
from fbfcli.gcode.scan import G0, G1, G2, G3, G5, LETTERS, MODAL, ODD, OTHER, Lines
from fbfcli.gcode.state import State, initial_state
from fbfcli.motion.moves import E, Moves, X, Y, Z
from fbfcli.printer import Printer

__all__ = ["Block", "Kind", "State", "initial_state", "interpret"]

NO_FEED = "moves before the first F are taken to be at 25 mm/s"
FIRST_ONLY = "a line has several commands: all are obeyed here, but Marlin and Klipper obey only the first"
COMBINABLE = frozenset((17, 18, 19, 20, 21, 40, 49, 54, 64, 80, 90, 91, 94))  # G words that may share a line

_NUMBERED = re.compile(r"^\s*N\s*\d+|\*.*$", re.IGNORECASE)
_MACRO = re.compile(r"\s*[A-Z_]{2}", re.IGNORECASE)
_PLAIN = re.compile(r"\s*([A-Z][A-Z0-9.+\- \t]*)?", re.IGNORECASE)
_PLUS = re.compile(r"(?<=[A-Z])([ \t]*)\+(?=[\d.])", re.IGNORECASE)


@dataclass(frozen=True)
class Block:
    """What n lines mean. Arrays have shape (n,); a mode is the one in force after the line.

    lines        : Lines
    moves        : Moves            straight moves, curves as chords; `moves.line` counts from 0 within the file
    kind         : ndarray of uint8 a Kind
    wait         : ndarray          dwell [s], 0 elsewhere
    known        : ndarray of bool  X and Y are where the file says (see `coordinates`); Z is assumed to be
    offset       : ndarray, shape (n, 3)  machine - logical coordinate of X, Y, Z [mm]
    xy_relative, e_relative, inch : ndarray of bool
    e_logical    : ndarray          the file's own E, resets included [mm]
    feed         : ndarray          F as written [mm/min or inch/min], nan before the first
    speed_factor : ndarray          M220, 1 at 100 %
    motion_mode  : ndarray of int   0, 1, 2, 3 or 5
    state        : ndarray of int   limits in force, index into `moves.limits`
    warnings     : tuple of str     each given once per file
    """

    lines: Lines
    moves: Moves
    kind: np.ndarray
    wait: np.ndarray
    known: np.ndarray
    offset: np.ndarray
    xy_relative: np.ndarray
    e_relative: np.ndarray
    inch: np.ndarray
    e_logical: np.ndarray
    feed: np.ndarray
    speed_factor: np.ndarray
    motion_mode: np.ndarray
    state: np.ndarray
    warnings: tuple[str, ...]


def interpret(lines: Lines, state: State, printer: Printer) -> tuple[Block, State]:
    """Meaning of `lines`, and the state after them. Raises GcodeError."""
    lines, odd = _odd_lines(lines, printer.firmware)
    refuse_absurd(lines)
    modes = modal(lines, odd, state, printer.firmware)
    way = track(lines, modes, state)
    motion_mode = motion_modes(lines, state)
    feed = feeds(lines, modes, state)
    moves, resting = moves_of(lines, modes, way, motion_mode[1:], feed.speed, state)
    warnings = modes.warnings
    if len(moves) and np.isnan(feed.written[moves.line[0] - lines.first + 1]) and NO_FEED not in state.warned:
        warnings += (NO_FEED,)
    block = Block(
        lines=lines,
        moves=moves,
        kind=modes.kind,
        wait=modes.wait,
        known=way.known[X][1:] & way.known[Y][1:],
        offset=np.stack([way.offset[axis][1:] for axis in (X, Y, Z)]).T,
        xy_relative=modes.xy_relative,
        e_relative=modes.e_relative,
        inch=modes.inch,
        e_logical=way.logical[E][1:],
        feed=feed.written[1:],
        speed_factor=modes.speed_factor,
        motion_mode=motion_mode[1:],
        state=modes.in_force,
        warnings=warnings,
    )
    return block, replace(_after(state, modes, way, feed), motion_mode=int(motion_mode[-1]), resting=resting,
                          warned=state.warned | set(warnings))  # fmt: skip


def _after(state: State, modes: Modal, way: Track, feed: Feed) -> State:
    """State after the last line, as far as it lies in coordinates, modes and feed rate."""
    x, y, z, e = (float(at[-1]) for at in way.logical)
    u, v, w, f = (float(at[-1]) for at in way.offset)
    return replace(
        state,
        logical=(x, y, z, e),
        offset=(u, v, w, f),
        known=(bool(way.known[X][-1]), bool(way.known[Y][-1])),
        limits=modes.limits,
        in_force=int(modes.last["in_force"]),
        g91=bool(modes.last["g91"]),
        m83=bool(modes.last["m83"]),
        inch=bool(modes.last["inch"]),
        plane=int(modes.last["plane"]),
        feed=float(feed.written[-1]),
        feed_unit=feed.unit,
        speed_factor=modes.last["speed_factor"],
    )


def _odd_lines(lines: Lines, firmware: str) -> tuple[Lines, Mapping[int, tuple[Effect, ...]]]:
    """`lines` with every ODD line resolved, and the effects of those that set modes."""
    at = np.flatnonzero(lines.code == ODD).tolist()
    if not at:
        return lines, {}
    code = lines.code.copy()
    words = {name: column.copy() for name, column in lines.words.items()}
    effects: dict[int, tuple[Effect, ...]] = {}
    for i in at:
        text = code_of(lines.raw(i))
        if _MACRO.match(text) or "{" in text:
            code[i] = OTHER
            continue
        try:
            code[i], numbers, found = _commands(_words(_NUMBERED.sub("", text)), firmware)
        except GcodeError as error:
            raise at_line(error, lines, i) from None
        for name in LETTERS:
            words[name][i] = numbers.get(name, np.nan)
        if found:
            effects[i] = found
    return replace(lines, code=code, words=words), effects


def _words(text: str) -> list[tuple[str, float]]:
    """Letters and numbers of a line, by pygcode, which passes over odd characters and does not know `+3`."""
    from pygcode.exceptions import GCodeWordStrError
    from pygcode.words import text2words

    if not _PLAIN.fullmatch(text):
        raise GcodeError("a character that has no place in a motion", remedy="correct the line, or make it a comment")
    try:
        return [(word.letter, float(word.value)) for word in text2words(_PLUS.sub(r"\1", text))]
    except (GCodeWordStrError, ValueError) as error:
        raise GcodeError(f"not a motion: {error}", remedy="every letter needs one number") from None


def _commands(words: list[tuple[str, float]], firmware: str) -> tuple[int, dict[str, float], tuple[Effect, ...]]:
    """Code, numbers and mode changes of one line's words. Raises GcodeError."""
    gs = [value for letter, value in words if letter == "G"]
    motions = [int(g) for g in gs if g in (G0, G1, G2, G3, G5)]
    modes = [g for g in gs if g not in (G0, G1, G2, G3, G5)]
    numbers = {letter: value for letter, value in words if letter != "G"}
    if len(numbers) + len(gs) < len(words):
        raise GcodeError("a letter occurs twice", remedy="keep one of them")
    if numbers.get("H") and not modes:
        return OTHER, {}, (UNKNOWN,)  # RepRapFirmware: a move until an endstop, or of single motors
    if len(motions) > 1 or not COMBINABLE.issuperset(modes):
        raise GcodeError("several commands on one line", remedy="give each command a line of its own")
    if strange := sorted(set(numbers) - set(LETTERS)):
        raise GcodeError(f"{strange[0]} is not supported on a motion line", remedy="only X, Y, Z and E are axes here")
    effects = tuple(effect_of(f"G{g:g}", firmware) for g in modes)
    if modes and firmware != "reprapfirmware":
        effects = (Effect(Kind.IN_ORDER, warning=FIRST_ONLY), *effects)
    if motions:
        return motions[0], numbers, effects
    return (MODAL if numbers else OTHER), numbers, effects
