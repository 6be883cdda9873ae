"""Passages for tests of pictures: a square of layers, and a nozzle that swings around it by what the test says."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from fbfcli.verify.execution import Execution
from fbfcli.verify.passage import Passage

DT = 1e-3
SIDE_MM, SPEED = 20.0, 100.0
SIDE = round(SIDE_MM / SPEED / DT)  # samples
LAYER = 4 * SIDE  # samples
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * SIDE_MM


def square(layers: int, amplitude: float, seed: int = 0, travel: bool = True) -> Passage:
    """Squares on top of each other: behind each corner the nozzle swings, by up to `amplitude` [mm], and calms down."""
    rng = np.random.default_rng(seed)
    n = layers * LAYER
    k = np.arange(n)
    side, along = (k // SIDE) % 4, (k % SIDE) * SPEED * DT
    tangent = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])[side]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    desired = CORNERS[side] + along[:, None] * tangent + 100.0
    size = np.repeat(rng.uniform(0.2, 1.0, 4 * layers), SIDE) * amplitude
    across = size * np.exp(-along / 4.0) * np.cos(2 * np.pi * along / 2.5)
    layer = k // LAYER
    extruding = (side < 3) | ~np.array(travel)
    execution = Execution(
        dt=DT, begin=np.array([0]), rest=np.array([0]), goes_on=True, time=k * DT, line=k // SIDE, layer=layer,
        feature=side % 2, desired=desired, command=desired,
        motion=np.column_stack([desired, 0.2 * (layer + 1), 0.1 * k]), extruding=extruding,
    )  # fmt: skip
    nozzle = desired + across[:, None] * normal
    return Passage(execution, nozzle, np.abs(across), np.abs(across), across, np.zeros(n))


def pieces(passage: Passage, cuts: list[int]) -> list[Passage]:
    """The passage as it may arrive."""
    edges = [0, *sorted({cut for cut in cuts if 0 < cut < len(passage)}), len(passage)]
    return [passage[a:b] for a, b in pairwise(edges)]
