"""Toolhead positions to motor positions, and back.

q motors [mm], x toolhead [mm]; both have shape (n, 3). E has a motor of its own and is not here.

cartesian : q = x
corexy    : q_a = x + y, q_b = x - y (Moyer, corexy.com; Klipper kin_corexy.c)
delta     : carriage i on a vertical tower at T_i, an arm of length L from it to the toolhead:
            q_i = z + sqrt(L^2 - |T_i - (x, y)|^2) (Klipper kin_delta.c), back by intersecting three spheres

Forces F at the toolhead are forces f at the motors, J^T f = F with J = dq / dx: the work is the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Protocol

import numpy as np

from fbfcli.errors import LimitError, ProfileError
from fbfcli.printer import Printer

TOWERS_DEG = (210.0, 330.0, 90.0)  # a, b, c as seen from above, counter-clockwise from +X


class Kinematics(Protocol):
    """How three motors move a toolhead; `names` are the motors'."""

    @property
    def names(self) -> tuple[str, str, str]: ...

    def motors(self, x: np.ndarray) -> np.ndarray:
        """Motor positions for toolhead positions, nan where the machine cannot reach them."""
        ...

    def toolhead(self, q: np.ndarray) -> np.ndarray:
        """Toolhead positions for motor positions, nan where there are none."""
        ...

    def forces(self, x: np.ndarray, F: np.ndarray) -> np.ndarray:
        """Forces of the motors along q that hold forces F at the toolhead [N], shape (n, 3)."""
        ...


@dataclass(frozen=True)
class Cartesian:
    """A motor for each axis."""

    names: tuple[str, str, str] = ("x", "y", "z")

    def motors(self, x: np.ndarray) -> np.ndarray:
        """The same."""
        return np.asarray(x, float)

    def toolhead(self, q: np.ndarray) -> np.ndarray:
        """The same."""
        return np.asarray(q, float)

    def forces(self, x: np.ndarray, F: np.ndarray) -> np.ndarray:
        """The same."""
        return np.asarray(F, float)


@dataclass(frozen=True)
class CoreXY:
    """Two motors that hold X and Y by one pair of belts."""

    names: tuple[str, str, str] = ("a", "b", "z")

    def motors(self, x: np.ndarray) -> np.ndarray:
        """Sum and difference of X and Y."""
        return np.column_stack([x[:, 0] + x[:, 1], x[:, 0] - x[:, 1], x[:, 2]])

    def toolhead(self, q: np.ndarray) -> np.ndarray:
        """Half of sum and difference."""
        return np.column_stack([0.5 * (q[:, 0] + q[:, 1]), 0.5 * (q[:, 0] - q[:, 1]), q[:, 2]])

    def forces(self, x: np.ndarray, F: np.ndarray) -> np.ndarray:
        """Half of sum and difference: both motors bear a push along X or Y."""
        return self.toolhead(F)


@dataclass(frozen=True)
class Delta:
    """Three carriages on vertical towers.

    radius : from the centre to each tower, less the effector's and the carriage's offset [mm]
    arm    : length of the arms [mm]
    """

    radius: float
    arm: float
    names: tuple[str, str, str] = ("a", "b", "c")

    @property
    def towers(self) -> np.ndarray:
        """X and Y of the towers, shape (3, 2)."""
        return self.radius * np.array([[cos(radians(angle)), sin(radians(angle))] for angle in TOWERS_DEG])

    def motors(self, x: np.ndarray) -> np.ndarray:
        """Height of each carriage."""
        q = np.empty((len(x), 3))
        for i, (tx, ty) in enumerate(self.towers.tolist()):
            dx, dy = x[:, 0] - tx, x[:, 1] - ty
            left = self.arm**2 - dx * dx - dy * dy
            q[:, i] = x[:, 2] + np.sqrt(np.where(left >= 0.0, left, np.nan))
        return q

    def toolhead(self, q: np.ndarray) -> np.ndarray:
        """The lower point at the arm's length from all three carriages.

        |x - c_i|^2 = L^2, c_i = (T_i, q_i), |T_i| = R. Differences of the three equations are linear:
        2 (T_i - T_j) . (x, y) = (q_i^2 - q_j^2) - 2 (q_i - q_j) z, so (x, y) = p + s z; one sphere gives z.
        """
        towers = self.towers
        inverse = np.linalg.inv(2.0 * (towers[1:] - towers[0]))
        p = (q[:, 1:] ** 2 - q[:, :1] ** 2) @ inverse.T
        s = -2.0 * (q[:, 1:] - q[:, :1]) @ inverse.T
        from_tower = p - towers[0]
        a = 1.0 + np.sum(s * s, axis=1)
        half_b = np.sum(s * from_tower, axis=1) - q[:, 0]
        c = np.sum(from_tower * from_tower, axis=1) + q[:, 0] ** 2 - self.arm**2
        left = half_b * half_b - a * c
        z = (-half_b - np.sqrt(np.where(left >= 0.0, left, np.nan))) / a
        return np.column_stack([p + s * z[:, None], z])

    def forces(self, x: np.ndarray, F: np.ndarray) -> np.ndarray:
        """From the slopes of the arms: dq_i = dz + (T_i - (x, y)) . d(x, y) / height of arm i; nan out of reach."""
        J = np.ones((len(x), 3, 3))
        offset = self.towers[None] - x[:, None, :2]
        J[:, :, :2] = offset / (self.motors(x) - x[:, 2:])[:, :, None]
        return np.linalg.solve(J.transpose(0, 2, 1), F[:, :, None])[:, :, 0]


def in_reach(kinematics: Kinematics, x: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Motor positions for toolhead positions that lines, from 0, ask for. Raises LimitError where there are none."""
    q = kinematics.motors(x)
    if np.isnan(q).any():
        i = int(np.flatnonzero(np.isnan(q).any(axis=1))[0])
        at = x[i].tolist()
        raise LimitError(
            f"line {line[i] + 1}: X{at[0]:.3f} Y{at[1]:.3f} Z{at[2]:.3f} is out of the arms' reach "
            "(check delta_radius and arm_length, or move the part to the middle)"
        )
    return q


def kinematics_of(printer: Printer) -> Kinematics:
    """The printer's kinematics. Raises ProfileError where a delta's size is not known."""
    if printer.kinematics == "corexy":
        return CoreXY()
    if printer.kinematics == "delta":
        if printer.delta_radius is None or printer.arm_length is None:
            raise ProfileError(
                f"{printer.name}: a delta's motors need delta_radius and arm_length (write both under [printer])"
            )
        return Delta(printer.delta_radius, printer.arm_length)
    return Cartesian()
