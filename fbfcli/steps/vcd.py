"""Steps as a value change dump (IEEE 1364-2005, clause 18): what a logic analyser would see on STEP and DIR.

Each motor has two wires, `<name>_step` and `<name>_dir`. A step's pulse begins at its time and lasts as long as the
driver wants, in whole ticks; the direction changes its set-up time before the step. The tick is 1 us if the driver's
pulses fit, else 100 or 10 ns: viewers hold a sample for each.

    $timescale 1 us $end
    $var wire 1 ! x_step $end
    $var wire 1 " x_dir $end
    $enddefinitions $end
    #0
    $dumpvars 0! 0" $end
    #12499
    1"
    #12500
    1!
    #12502
    0!
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import ceil

import numpy as np

from fbfcli.digits import chosen, decimal, fixed, only, rows
from fbfcli.errors import FbfError, ProfileError
from fbfcli.printer import Driver
from fbfcli.steps.stream import Motors, MotorSteps, Piece
from fbfcli.units import NS_PER_S

FIRST_CODE = ord("!")  # identifiers are printable characters
TICKS_NS = {1000: b"1 us", 100: b"100 ns", 10: b"10 ns", 1: b"1 ns"}
_VARIABLE = re.compile(rb"\$var\s+wire\s+1\s+(\S)\s+(\w+?)_(step|dir)\s+\$end")
_TIMESCALE = re.compile(rb"\$timescale\s+(1|10|100)\s*(us|ns)\s+\$end")
_CHANGE = re.compile(rb"#(\d+)|([01])(\S)")


def tick_of(driver: Driver) -> int:
    """The longest tick in which a pulse, a pause and the set-up time fit between two steps [ns]."""
    gap = NS_PER_S / driver.max_step_rate
    for tick in TICKS_NS:
        if (ticks(driver.step_pulse, tick) + max(ticks(driver.direction_setup, tick), 1) + 1) * tick <= gap:
            return tick
    raise ProfileError(f"a pulse, a pause and the direction's set-up time do not fit into {gap:.0f} ns (max_step_rate)")


def ticks(seconds: float, tick: int) -> int:
    """Whole ticks that a time needs."""
    return ceil(seconds * NS_PER_S / tick - 1e-6)


class VcdWriter:
    """Writes a stream as a value change dump."""

    def __init__(self, motors: Motors, driver: Driver):
        self._names = motors.names
        self._tick = tick_of(driver)
        self._pulse = ticks(driver.step_pulse, self._tick)
        self._setup = max(ticks(driver.direction_setup, self._tick), 1)
        texts = [b"%d%c\n" % (value, FIRST_CODE + i) for i in range(2 * len(self._names)) for value in (0, 1)]
        self._texts = [*texts, *(b"\n" + text for text in texts)]  # the first at a time ends the line of its stamp
        self._forward = [False] * len(self._names)  # what each dir wire says
        self._waiting = (np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))  # changes to come: ticks, texts
        self._last = 0  # tick of the last change

    def head(self) -> Iterator[bytes]:
        """Definitions, and the state at the beginning."""
        wires = [f"{name}_{kind}" for name in self._names for kind in ("step", "dir")]
        lines = [b"$version fbf steps $end", b"$timescale %s $end" % TICKS_NS[self._tick], b"$scope module motors $end"]
        lines += [b"$var wire 1 %c %s $end" % (FIRST_CODE + i, wire.encode()) for i, wire in enumerate(wires)]
        lines += [b"$upscope $end", b"$enddefinitions $end", b"#0", b"$dumpvars"]
        yield b"\n".join(lines + [b"0%c" % (FIRST_CODE + i) for i in range(len(wires))] + [b"$end\n"])

    def add(self, piece: Piece) -> Iterator[bytes]:
        """Changes that nothing later can come before."""
        at, text = [self._waiting[0]], [self._waiting[1]]
        for i, steps in enumerate(piece.steps.motors):
            if not len(steps):
                continue
            time = np.rint(steps.time / self._tick).astype(np.int64)
            turned = np.flatnonzero(np.diff(steps.forward, prepend=self._forward[i]))
            self._forward[i] = bool(steps.forward[-1])
            at += [np.maximum(time[turned] - self._setup, 0), time, time + self._pulse]
            up, down = np.full(len(time), 4 * i + 1), np.full(len(time), 4 * i)
            text += [4 * i + 2 + steps.forward[turned], up, down]
        horizon = piece.steps.end // self._tick - self._setup
        yield self._written(np.concatenate(at), np.concatenate(text), horizon)

    def _written(self, at: np.ndarray, text: np.ndarray, horizon: int) -> bytes:
        order = np.argsort(at, kind="stable")
        at, text = at[order], text[order]
        due = int(np.searchsorted(at, horizon))
        self._waiting = at[due:], text[due:]
        at, text = at[:due], text[:due]
        if not due:
            return b""
        new = np.diff(at, prepend=self._last) != 0
        self._last = int(at[-1])
        stamp = only([*fixed(b"#"), *decimal(at)], new)
        return rows(due, stamp, chosen(self._texts, text + len(self._texts) // 2 * new))

    def end(self) -> Iterator[bytes]:
        """The last changes."""
        yield self._written(*self._waiting, horizon=np.iinfo(np.int64).max)
        yield b"#%d\n" % (self._last + 1)


def read_vcd(data: bytes) -> dict[str, MotorSteps]:
    """The steps of each motor, times in whole ticks. Raises FbfError."""
    head, _, body = data.partition(b"$enddefinitions $end")
    scale = _TIMESCALE.search(head)
    wires = {code: (name.decode(), kind) for code, name, kind in _VARIABLE.findall(head)}
    if not scale or not wires:
        raise FbfError("not a value change dump of steps: no $timescale, or no wires called <motor>_step")
    tick = int(scale[1]) * (1000 if scale[2] == b"us" else 1)
    now, forward = 0, dict.fromkeys((name for name, _ in wires.values()), False)
    found: dict[str, tuple[list[int], list[bool]]] = {name: ([], []) for name in forward}
    for stamp, value, code in _CHANGE.findall(body):
        if stamp:
            now = int(stamp)
            continue
        name, kind = wires[code]
        if kind == b"dir":
            forward[name] = value == b"1"
        elif value == b"1":
            found[name][0].append(now * tick)
            found[name][1].append(forward[name])
    return {name: MotorSteps(np.array(time, np.int64), np.array(way, bool)) for name, (time, way) in found.items()}
