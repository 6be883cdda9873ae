"""Random moves as a slicer would write them, and worse."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from fbfcli.motion.moves import Moves
from fbfcli.printer import Limits

# X and Y, Z, E per mm of each kind of move
KINDS = {"print": (1, 0, 0.03), "travel": (1, 0, 0), "wipe": (1, 0, -0.05), "spiral": (1, 0.01, 0.03),
         "retract": (0, 0, -0.04), "unretract": (0, 0, 0.04), "lift": (0, 0.02, 0)}
OFTEN = ("print", "print", "print", *KINDS)


def random_limits(rng: np.random.Generator, **fixed) -> Limits:
    values = {
        "velocity": rng.choice((80.0, 300.0)),
        "acceleration": rng.choice((500.0, 3000.0, 1e8)),
        "travel_acceleration": rng.choice((1000.0, 7000.0)),
        "retract_acceleration": 1500.0,
        "axis_velocity": (200.0, 250.0, 15.0, rng.choice((30.0, 75.0))),
        "axis_acceleration": (9000.0, 4000.0, 200.0, rng.choice((800.0, 5000.0, np.inf))),
        "jerk": (rng.choice((8.0, 20.0)), 9.0, 0.4, rng.choice((1.0, 2.5))),
        "junction_deviation": rng.choice((np.nan, 0.013)),
        "square_corner_velocity": rng.choice((0.0, 5.0, 12.0)),
        "minimum_cruise_ratio": rng.choice((0.0, 0.5, 0.9)),
    }
    return Limits(**{**values, **fixed})


@st.composite
def paths(draw, max_size: int = 40, kinds=OFTEN, states: int = 2, **fixed) -> Moves:
    """1 to max_size moves; half of them in round numbers, where several limits meet in one value."""
    n, rounded = draw(st.integers(1, max_size)), draw(st.booleans())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    limits = tuple(random_limits(rng, **fixed) for _ in range(rng.integers(1, states + 1)))
    if rounded:
        turn, d = rng.choice((0, 0, 0.5, 1, 0.25), n) * np.pi, rng.choice((0.1, 1.0, 2.0, 20.0), n)
        speed = rng.choice((50.0, 100.0), n)
    else:
        turn = rng.normal(0, rng.choice((1e-7, 0.1, 2.0)), n) * (rng.random(n) < 0.9)
        d, speed = np.exp(rng.uniform(np.log(0.005), np.log(60), n)), rng.uniform(1.0, 400.0, n)
    angle = np.cumsum(turn)
    flat, z, e = np.array([KINDS[kind] for kind in rng.choice(kinds, n)]).T * d
    delta = np.stack((flat * np.cos(angle), flat * np.sin(angle), z, e), axis=1)
    start = np.vstack((np.zeros(4), np.cumsum(delta, axis=0)[:-1]))
    stop, state = rng.random(n) < 0.1, rng.integers(0, len(limits), n)
    return Moves(start, delta, speed, stop, state, np.arange(n), limits)


def moves_of(delta, speed: float = 100.0, limits: Limits | None = None) -> Moves:
    """Moves with one speed and one set of limits."""
    delta = np.asarray(delta, dtype=float)
    n = len(delta)
    start = np.vstack((np.zeros(4), np.cumsum(delta, axis=0)[:-1]))
    return Moves(start, delta, np.full(n, float(speed)), np.zeros(n, bool), np.zeros(n, int), np.arange(n),
                 (limits or Limits(),))
