"""Random motor positions and step streams, and what a stream's steps add up to."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from fbfcli.steps.stream import Motors, MotorSteps, Piece, Steps, joined

DT = 1e-3
NS = 1_000_000  # per period
NO_JUMP = np.zeros(0, dtype=np.int64)
MOTORS = Motors(("x", "y", "e"), (80.0, 100.0, 415.5))
TRAVEL = 100.0  # mm


@st.composite
def motions(draw: st.DrawFn, top_speed: float = 300.0) -> np.ndarray:
    """Positions of a motor at 1 ms: constant accelerations, rests, sudden turns, a little noise [mm]."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    pieces = draw(st.integers(1, 12))
    speed = [np.linspace(*rng.uniform(-top_speed, top_speed, 2), rng.integers(2, 60)) for _ in range(pieces)]
    for i in np.flatnonzero(rng.random(pieces) < 0.3):
        speed[i] = np.zeros(rng.integers(1, 40))
    x = TRAVEL + DT * np.cumsum(np.concatenate(speed)) + draw(st.sampled_from([0.0, 1e-9, 1e-5])) * rng.normal(
        size=sum(map(len, speed))
    )
    return np.concatenate([x[:1], x, x[-1:]])


@st.composite
def motor_steps(draw: st.DrawFn, most: int = 300) -> MotorSteps:
    """Steps of one motor: gaps from 4 us to a minute, smooth and not."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(0, most))
    if draw(st.booleans()):
        gap = np.exp(rng.uniform(np.log(4e3), np.log(6e10), n))
    else:
        gap = 4_000 + 1e6 * (1.0 + np.sin(np.arange(n) / 40.0 + rng.uniform(0, 6))) + rng.normal(0, 30, n)
    time = np.cumsum(np.maximum(gap, 4_000).astype(np.int64))
    forward = np.repeat(rng.random(n) < 0.5, rng.integers(1, 40, n))[:n]
    return MotorSteps(time, forward)


@st.composite
def streams(draw: st.DrawFn) -> tuple[Piece, ...]:
    """Steps of the MOTORS cut into pieces anywhere."""
    motors = [draw(motor_steps()) for _ in MOTORS.names]
    end = max([int(one.time[-1]) for one in motors if len(one)], default=0) + draw(st.integers(0, 10**10))
    cuts = [0, *sorted(draw(st.lists(st.integers(0, end), max_size=5))), end + 1]
    return tuple(cut_out(motors, a, b) for a, b in pairwise(cuts))


def cut_out(motors: list[MotorSteps], begin: int, end: int) -> Piece:
    """The steps from `begin` on and before `end` [ns]."""
    cut = [slice(*np.searchsorted(one.time, [begin, end])) for one in motors]
    parts = tuple(MotorSteps(one.time[rows], one.forward[rows]) for one, rows in zip(motors, cut, strict=True))
    nothing = np.zeros(0, dtype=np.int64)
    return Piece(Steps(begin, end, parts), nothing, np.zeros((0, len(motors))))


def whole(pieces: tuple[Piece, ...]) -> dict[str, MotorSteps]:
    """The steps of each motor of a stream."""
    return {name: joined([piece.steps.motors[i] for piece in pieces]) for i, name in enumerate(MOTORS.names)}


def written(writer, pieces: tuple[Piece, ...]) -> bytes:
    """All that a writer makes of a stream."""
    parts = [*writer.head()]
    for piece in pieces:
        parts += writer.add(piece)
    return b"".join([*parts, *writer.end()])


def standing(steps: MotorSteps, start: int, at: np.ndarray) -> np.ndarray:
    """Where a motor stands at times `at` [ns]: after the steps at that time and before [steps]."""
    position = start + np.concatenate([[0], np.cumsum(np.where(steps.forward, 1, -1))])
    return position[np.searchsorted(steps.time, at, side="right")]
