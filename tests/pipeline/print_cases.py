"""Random prints, what the pipeline makes of them, and what a firmware reads in that."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from fbfcli.gcode.interpret import Block, initial_state, interpret
from fbfcli.gcode.scan import chunks, scan
from fbfcli.motion.moves import Moves
from fbfcli.motion.timing import executed
from fbfcli.pipeline import Done, Settings, compensate
from fbfcli.printer import Axis, ImpulseResponse, Limits, ModalModel, Mode, Model, Printer

RIGID = ImpulseResponse((1.0,), 1e-3)
SOFT = ModalModel((Mode(40.0, 0.06),))
LIMITS = Limits(velocity=300.0, acceleration=3000.0, travel_acceleration=4000.0, retract_acceleration=2000.0,
                axis_velocity=(300.0, 300.0, 20.0, 80.0), axis_acceleration=(9000.0, 8000.0, 500.0, 5000.0),
                jerk=(10.0, 9.0, 0.4, 2.5))  # fmt: skip


def printer(
    firmware: str = "marlin", model: Model = SOFT, command_velocity: float = 600.0, rate: float = 300.0
) -> Printer:
    x, y = (Axis(name, (-50.0, 300.0), 80.0, command_velocity, 30_000.0, model) for name in "xy")
    return Printer("test", "", firmware, "cartesian", (x, y, Axis("z", (0.0, 300.0), 400.0)), LIMITS, rate)


@dataclass(frozen=True)
class Written:
    """A compensated file, and what it was made from."""

    source: bytes
    text: bytes
    done: Done
    printer: Printer

    @property
    def lines(self) -> list[bytes]:
        return self.text.splitlines()

    def block(self) -> Block:
        return read(self.text, self.printer)


def compensated(
    text: str | bytes, machine: Printer | None = None, settings: Settings | None = None, size: int = 1 << 19
) -> Written:
    """The pipeline over a text that arrives in chunks of `size` bytes, times filled in."""
    source = text.encode() if isinstance(text, str) else text
    machine = machine or printer()
    out = io.BytesIO()
    done = compensate(chunks(io.BytesIO(source), size), machine, settings or Settings(method="zv"), out.write)
    for patch in done.patches:
        out.seek(patch.offset)
        out.write(patch.line.padded(patch.elapsed, done.time))
    return Written(source, out.getvalue(), done, machine)


def bare(line: bytes) -> bytes:
    return line.strip().removeprefix(DEFERRED)


def in_order(wanted: list[bytes], found: list[bytes]) -> bytes | None:
    """The first of `wanted` that does not follow those before it in `found`."""
    rest = iter(found)
    return next((line for line in wanted if not any(line == other for other in rest)), None)


def read(text: str | bytes, machine: Printer) -> Block:
    source = text.encode() if isinstance(text, str) else text
    return interpret(scan(source), initial_state(machine), machine)[0]


def end_of(moves: Moves) -> np.ndarray:
    """X, Y, Z, E after the last move; E is the sum of all that was pushed."""
    return moves.start[-1] + moves.delta[-1]


def print_time(text: str | bytes, machine: Printer) -> float:
    """What the firmware's planner needs for a file, dwells included [s]."""
    block = read(text, machine)
    return float(executed(block.moves, machine.firmware).duration.sum() + block.wait.sum())


DEFERRED = b"; fbf: "
START = "G28\nG90\nM83\nG1 Z0.3 F900\nG1 X100 Y100 F6000\n"
FANS = ("M106 S{}", "M117 layer {}", "; comment {}", "M104 S2{}", ";TYPE:wall {}", "", "M73 P1{}")
WAITS = ("G4 P30", "M400", "MY_MACRO A=1", "M190 S60", "T0", "G4 P1")
LIMIT_LINES = {
    "marlin": ("M204 P{a} T{a}", "M204 S{a}", "M205 X8 Y7", "M201 X{a}"),
    "klipper": ("SET_VELOCITY_LIMIT ACCEL={a}", "M204 S{a}", "SET_VELOCITY_LIMIT SQUARE_CORNER_VELOCITY=7"),
    "reprapfirmware": ("M204 P{a} T{a}", "M566 X600 Y500", "M201 X{a}"),
}
# fmt: off
ALL = ("print", "print", "print", "arc", "travel", "retract", "lift", "fan", "fan", "wait", "limits", "reset", "feed",
       "absolute_e", "relative_e", "relative", "override", "wipe", "spiral", "declare")
# fmt: on


def random_print(seed: int, size: int, firmware: str, kinds: tuple[str, ...] = ALL) -> str:
    """A print of `size` pieces of the given kinds, in the words of a slicer."""
    rng = np.random.default_rng(seed)
    at, e, absolute_e, relative, lines = np.array([100.0, 100.0]), 0.0, False, False, []

    def step(feed: bool, pushed: float, z: float = 0.0) -> str:
        nonlocal at, e
        turn, d = rng.uniform(0, 2 * np.pi), float(np.exp(rng.uniform(np.log(0.05), np.log(25.0))))
        to = np.round(np.clip(at + d * np.array([np.cos(turn), np.sin(turn)]), 20.0, 200.0), 3)
        x, y = to - at if relative else to
        at, e = to, e + round(pushed * d, 5)
        words = f"G1 X{x:.3f} Y{y:.3f}"
        if z:
            words += f" Z{z if relative else 0.3 + z:.3f}"
        if pushed:
            words += f" E{e if absolute_e else round(pushed * d, 5):.5f}"
        return words + (f" F{rng.choice((1500, 4800, 9000, 12000))}" if feed else "")

    for kind in rng.choice(kinds, size):
        if kind == "print":
            lines += [step(rng.random() < 0.2, 0.033) for _ in range(rng.integers(1, 8))]
        elif kind == "travel":
            lines.append(step(True, 0.0))
        elif kind == "wipe":
            lines.append(step(False, -0.05))
        elif kind == "spiral":
            lines.append(step(False, 0.03, 0.002))
        elif kind == "arc" and not relative:
            lines.append(f"G2 X{at[0]:.3f} Y{at[1]:.3f} I{rng.uniform(-3, 3):.3f} J{rng.uniform(0.1, 3):.3f}")
        elif kind == "retract":
            push = float(rng.choice((-0.8, 0.8)))
            e += push
            lines.append(f"G1 E{e if absolute_e else push:.5f} F2100")
        elif kind == "lift" and not relative:
            lines.append(f"G1 Z{rng.choice((0.5, 0.7))} F900")
        elif kind == "fan":
            lines.append(str(rng.choice(FANS)).format(rng.integers(10)))
        elif kind == "wait":
            lines.append(str(rng.choice(WAITS)))
            lines += ["G90", f"G1 X{at[0]:.3f} Y{at[1]:.3f}"]
            lines += ["G91" if relative else "G90", "M82" if absolute_e else "M83"]
        elif kind == "limits":
            lines.append(str(rng.choice(LIMIT_LINES[firmware])).format(a=rng.choice((800, 2500, 6000))))
        elif kind == "reset":
            e = 0.0
            lines.append("G92 E0")
        elif kind == "feed":
            lines.append(f"G1 F{rng.choice((2400, 7200))}")
        elif kind == "absolute_e" and not relative:
            absolute_e, e = True, 0.0
            lines.append("M82\nG92 E0")
        elif kind == "relative_e":
            absolute_e = False
            lines.append("M83")
        elif kind == "relative":
            relative, absolute_e = not relative, False
            lines.append(("G91" if relative else "G90") + "\nM83")
        elif kind == "override":
            lines.append(f"M220 S{rng.choice((80, 100, 150))}")
        elif kind == "declare" and not relative:
            at = np.round(at + rng.choice((-5.0, 5.0), 2), 3)
            lines.append(f"G92 X{at[0]:.3f} Y{at[1]:.3f}")
    return START + "\n".join(lines) + "\n"


@st.composite
def prints(draw: st.DrawFn, firmware: str, kinds: tuple[str, ...] = ALL, most: int = 25) -> str:
    """Prints of up to `most` pieces."""
    return random_print(draw(st.integers(0, 2**32 - 1)), draw(st.integers(1, most)), firmware, kinds)
