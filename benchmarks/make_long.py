"""Write a long print: `python benchmarks/make_long.py long.gcode [--moves 1000000 | --size 200000000]`.

A convex freeform column: short-segment perimeters, sparse and solid infill, travel with retraction, and the fan,
progress and type lines of a slicer. A million moves are four hours at 5000 mm/s^2. Written layer by layer.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

CENTRE = 125.0  # mm
RADIUS = 31.0  # mm
LOOPS = 4  # perimeters of a layer
CORNERS = 260  # segments of a perimeter: 0.75 mm each
WIDTH = 0.45  # of a line [mm]
LAYER = 0.2  # mm
E_PER_MM = WIDTH * LAYER / (np.pi * 1.75**2 / 4)  # filament per path
SPARSE, SOLID = 2.4, 0.8  # spacing of infill lines [mm]
SOLID_EVERY = 5  # layers
TOP = 200.0  # highest layer [mm]: a file of more layers has thinner ones
MOVES_PER_LAYER = 1126  # about, to know how many layers a file will have
BYTES_PER_MOVE = 29.4  # about
START = "M140 S60\nM104 S210\nM190 S60\nM109 S210\nG28\nG90\nM83\nG92 E0\nG1 Z5 F900\n"
END = "M83\nG1 E-2 F2100\nM104 S0\nM140 S0\nM107\nG91\nG1 Z5 F900\nG90\nG28 X0\nM84\n"


def outline(layer: int, inset: float) -> np.ndarray:
    """One perimeter, shape (CORNERS + 1, 2), closed [mm]; it turns and breathes slowly from layer to layer."""
    angle = 2 * np.pi * np.arange(CORNERS + 1) / CORNERS
    turn = 0.01 * layer
    radius = RADIUS - inset + 0.8 * np.sin(3 * angle + turn) + 0.3 * np.sin(5 * angle - turn)
    return CENTRE + np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def infill(layer: int) -> np.ndarray:
    """Corners of a zigzag at +-45 degrees inside the innermost perimeter, shape (n, 2) [mm]."""
    side = np.sqrt(0.5) * np.array([[1, 1], [-1, 1]]) if layer % 2 else np.sqrt(0.5) * np.array([[1, -1], [1, 1]])
    u, v = ((outline(layer, LOOPS * WIDTH)[:-1] - CENTRE) @ side).T
    # the outline is convex: left and right of its lowest and highest point, u is a function of v
    low = int(np.argmin(v))
    u, v = np.roll(u, -low), np.roll(v, -low)
    high = int(np.argmax(v))
    spacing = SPARSE if layer % SOLID_EVERY else SOLID
    rows = np.arange(v[0] + spacing, v[high] - spacing, spacing)
    ends = np.column_stack([np.interp(rows, v[: high + 1], u[: high + 1]),
                            np.interp(rows, np.append(v[high:], v[0])[::-1], np.append(u[high:], u[0])[::-1])])
    ends[1::2] = ends[1::2, ::-1]
    return CENTRE + np.column_stack([ends.ravel(), np.repeat(rows, 2)]) @ side.T


def extrude(path: np.ndarray) -> tuple[str, int]:
    """Lines that print a path from its first point, and their number."""
    xy = np.round(path, 3)
    e = E_PER_MM * np.hypot(*np.diff(xy, axis=0).T)
    return "G1 X%.3f Y%.3f E%.5f\n" * len(e) % tuple(np.column_stack([xy[1:], e]).ravel()), len(e)


def travel(to: np.ndarray) -> tuple[str, int]:
    """Lines that retract, go to a point and prime again, and their number."""
    return f"G1 E-.8 F2100\nG1 X{to[0]:.3f} Y{to[1]:.3f} F15000\nG1 E.8 F2100\n", 3


def layer_text(layer: int, height: float, percent: int) -> tuple[str, int]:
    """One layer and its number of moves."""
    pieces: list[tuple[str, int]] = [
        (f";LAYER_CHANGE\n;Z:{height:.3f}\n;HEIGHT:{LAYER}\nM73 P{percent}\nG1 Z{height:.3f} F15000\nG92 E0\n", 1)]
    for loop in reversed(range(LOOPS)):
        path = outline(layer, loop * WIDTH)
        kind = "External perimeter" if loop == 0 else "Perimeter"
        head = f";TYPE:{kind}\n;WIDTH:{WIDTH}\nM106 S{200 + layer % 50}\nG1 F9000\n"
        pieces += [travel(path[0]), (head, 0), extrude(path)]
    path = infill(layer)
    kind = "Internal" if layer % SOLID_EVERY else "Solid"
    pieces += [travel(path[0]), (f";TYPE:{kind} infill\nM106 S255\nG1 F12000\n", 0), extrude(path)]
    return "".join(text for text, _ in pieces), sum(moves for _, moves in pieces)


def layers(count: int) -> Iterator[tuple[str, int]]:
    """Layer after layer without end; the first `count` of them fit under TOP."""
    step, layer = min(LAYER, TOP / count), 0
    while True:
        layer += 1
        yield layer_text(layer, step * layer, min(99, 100 * layer // count))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--moves", type=int, default=1_000_000)
    parser.add_argument("--size", type=int, help="bytes instead of moves")
    wanted = parser.parse_args()
    count = (wanted.size / BYTES_PER_MOVE if wanted.size else wanted.moves) / MOVES_PER_LAYER
    size = moves = 0
    with wanted.file.open("w") as file:
        size += file.write(START)
        for text, number in layers(max(1, int(count))):
            if size + len(text) > wanted.size if wanted.size else moves + number > wanted.moves:
                break
            size, moves = size + file.write(text), moves + number
        file.write(END)
    print(f"{wanted.file}: {moves} moves, {size} bytes")


if __name__ == "__main__":
    main()
