"""Solids to slice, as triangles: made to ring (tower, star) and made to curve (hull).

A solid is an ndarray of shape (n, 3, 3): triangle, corner, X Y Z [mm]; centred on the origin, standing on Z = 0.
"""

from __future__ import annotations

import numpy as np

SIDE = 40.0  # of the tower [mm]
# along a wall, from one corner to the next: where it steps, and how far out of the wall it goes from there [mm]
STEPS = ((6.0, 1.2), (7.0, 0.0), (14.0, -1.2), (15.5, 0.0), (22.0, 2.0), (25.0, 0.0), (32.0, -0.6), (34.0, 0.0))


def ringing_tower(height: float = 6.0) -> np.ndarray:
    """A square tower; ridges and notches interrupt each wall and leave room for the ringing after them."""
    half = SIDE / 2
    wall = [(-half, -half)]
    out = 0.0
    for along, level in STEPS:
        wall += [(along - half, -half - out), (along - half, -half - level)]
        out = level
    corners = np.array(wall)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])  # row vectors: a quarter turn counter-clockwise
    return prism(np.vstack([corners @ np.linalg.matrix_power(turn, k) for k in range(4)]), height)


def star(points: int = 5, outer: float = 25.0, inner: float = 10.0, height: float = 6.0) -> np.ndarray:
    """A star: long straights that meet in sharp and in blunt corners, in directions that are not the axes'."""
    angle = np.pi / 2 + np.pi / points * np.arange(2 * points)
    radius = np.where(np.arange(2 * points) % 2, inner, outer)
    return prism(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), height)


def hull(length: float = 50.0, height: float = 6.0, corners: int = 240, layers: int = 30) -> np.ndarray:
    """A boat's hull with a flare: curvature everywhere, sharp only at the bow."""
    angle = 2 * np.pi * np.arange(corners) / corners
    z = np.linspace(0.0, height, layers + 1)
    flare = 0.7 + 0.3 * np.sqrt(z / height)
    x = length / 2 * np.outer(0.85 + 0.15 * flare, np.cos(angle))
    y = length / 5 * np.outer(flare, np.sin(angle) * (1.0 - 0.45 * np.cos(angle)))
    rings = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)], axis=2)
    return loft(rings, cap=fan(corners))


def prism(outline: np.ndarray, height: float) -> np.ndarray:
    """The solid above a simple polygon, shape (n, 2), counter-clockwise."""
    rings = np.stack([np.column_stack([outline, np.full(len(outline), z)]) for z in (0.0, height)])
    return loft(rings, cap=ears(outline))


def loft(rings: np.ndarray, cap: np.ndarray) -> np.ndarray:
    """The solid through counter-clockwise rings, shape (layers, n, 3); `cap` (k, 3) closes the first and the last."""
    here, right = rings, np.roll(rings, -1, axis=1)
    walls = [np.stack([here[:-1], right[:-1], right[1:]], axis=2), np.stack([here[:-1], right[1:], here[1:]], axis=2)]
    ends = [rings[0][cap[:, ::-1]], rings[-1][cap]]
    return np.concatenate([wall.reshape(-1, 3, 3) for wall in walls] + ends)


def fan(corners: int) -> np.ndarray:
    """Triangles of a convex polygon, shape (n - 2, 3)."""
    i = np.arange(1, corners - 1)
    return np.column_stack([np.zeros_like(i), i, i + 1])


def ears(outline: np.ndarray) -> np.ndarray:
    """Triangles of a simple polygon by ear clipping (Meisters 1975), shape (n - 2, 3)."""
    left = list(range(len(outline)))
    triangles = []
    while len(left) > 3:
        k = next(k for k in range(len(left)) if _is_ear(outline, left, k))
        triangles.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    return np.array([*triangles, tuple(left)])


def _is_ear(outline: np.ndarray, left: list[int], k: int) -> bool:
    a, b, c = (outline[left[j % len(left)]] for j in (k - 1, k, k + 1))
    if _turn(a, b, c) <= 0:
        return False
    others = [outline[j] for j in left if j not in (left[k - 1], left[k], left[(k + 1) % len(left)])]
    return not any(min(_turn(a, b, p), _turn(b, c, p), _turn(c, a, p)) >= 0 for p in others)


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Twice the area of the triangle, positive counter-clockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def stl(triangles: np.ndarray) -> bytes:
    """The solid as a binary STL file."""
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    record["corners"] = triangles
    return b"fbf sample part".ljust(80) + np.array(len(triangles), "<u4").tobytes() + record.tobytes()
