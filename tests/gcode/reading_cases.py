"""Reading a text in chunks, and motion lines in every spelling."""

from __future__ import annotations

import io

import numpy as np
from hypothesis import strategies as st

from fbfcli.gcode.interpret import Block, State, initial_state, interpret
from fbfcli.gcode.scan import chunks, scan
from fbfcli.motion.moves import Moves
from fbfcli.printer import FIRMWARES, Axis, Limits, Printer


def printer(firmware: str = "marlin") -> Printer:
    axes = (Axis("x", (-50, 300), 80), Axis("y", (-50, 300), 80), Axis("z", (0, 300), 400))
    return Printer("test", "", firmware, "cartesian", axes, Limits(), 300)


def blocks_of(text: bytes | str, firmware: str = "marlin", size: int = 1 << 19) -> tuple[list[Block], State]:
    """Every block of a text read in chunks of about `size` bytes, and the state after the last."""
    text = text.encode() if isinstance(text, str) else text
    machine = printer(firmware)
    state, first, blocks = initial_state(machine), 0, []
    for chunk in chunks(io.BytesIO(text), size):
        block, state = interpret(scan(chunk, first), state, machine)
        first += len(block.lines)
        blocks.append(block)
    return blocks, state


def whole(text: bytes | str, firmware: str = "marlin") -> tuple[Block, State]:
    """A text as one block, and the state after it."""
    machine = printer(firmware)
    return interpret(scan(text.encode() if isinstance(text, str) else text), initial_state(machine), machine)


def block_of(text: bytes | str, firmware: str = "marlin") -> Block:
    return whole(text, firmware)[0]


def moves_of(text: bytes | str, firmware: str = "marlin") -> Moves:
    return block_of(text, firmware).moves


def joined(blocks: list[Block], name: str) -> np.ndarray:
    """One array of the blocks' lines, or of their moves ("moves.delta")."""
    parts = [getattr(b.moves, name[6:]) if name.startswith("moves.") else getattr(b, name) for b in blocks]
    return np.concatenate(parts)


firmwares = st.sampled_from(FIRMWARES)
signs = st.sampled_from(["", "-", "+"])
digits = st.text("0123456789", min_size=1, max_size=7)
numbers = st.one_of(
    st.builds(lambda s, a: f"{s}{a}", signs, digits),
    st.builds(lambda s, a: f"{s}{a}.", signs, digits),
    st.builds(lambda s, b: f"{s}.{b}", signs, digits),
    st.builds(lambda s, a, b: f"{s}{a}.{b}", signs, digits, digits),
)
feeds = st.builds(lambda a: f"{a}.5", st.integers(1, 99999))


@st.composite
def motion_lines(draw: st.DrawFn) -> str:
    """A motion line in one of its many spellings."""
    letters = draw(st.lists(st.sampled_from("XYZE"), unique=True))
    words = [letter + draw(numbers) for letter in letters]
    if draw(st.booleans()):
        words.insert(draw(st.integers(0, len(words))), "F" + draw(feeds))
    head = draw(st.sampled_from(["G0", "G1", "G00", "G01"] + ([""] if words else [])))
    blank = draw(st.sampled_from([" ", "", "  ", "\t"]))
    line = blank.join(filter(None, [head, *words]))
    line = line.lower() if draw(st.booleans()) else line
    if draw(st.booleans()):
        line = f"N{draw(st.integers(0, 99999))} {line}"
    line += draw(st.sampled_from(["", "", "*71", " ; X1 Y2", ";", " (a Z3 comment)", "   "]))
    return draw(st.sampled_from(["", " "])) + line


OTHER_LINES = """
G90|G91|M82|M83|G92 E0|G92 X5|G92 X1.5 Y2 Z3 E4|G28|G28 X|G28 Z0|G4 P100|M400|M104 S200|M117 Go X5|T0|M220 S50|M204 S500
M204 P800 T900|M205 X8 Y8|SET_VELOCITY_LIMIT ACCEL=700|G10|G11|; only a comment|;TIME:12||EXCLUDE_OBJECT_END|PAUSE
M73 P3|G2 I2 J1|G3 X1 Y1 I.5 J.5 E1 F900|G17|G3 Z1 I2|G17 G91 G21|G5 X1 Y1 I1 P1 Q1
"""
other_lines = st.sampled_from(OTHER_LINES.replace("\n", "|").split("|"))
files = st.lists(st.one_of(motion_lines(), motion_lines(), other_lines), max_size=40).map("\n".join)
