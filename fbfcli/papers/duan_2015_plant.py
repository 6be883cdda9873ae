"""What Duan 2015 tries its methods on: a plant with a zero at 1.1 or -1.1, and a path that is given as a drawing only.

G = K (1 - a z^-1) / (1 - p z^-1), K = (1 - p) / (1 - a), p = 0.5 (Eq. 37); E + 1 = 501 samples at 10 kHz.
The path of Figs. 2 and 3 is not given in numbers. In its place each axis makes minimum-jerk moves to and fro, from
rest to rest: MOVES of them, each DISTANCE long. These two numbers per axis are such that NPZ-ignore's error at a = 1.1,
which is 11 times the step per sample, and ZPETC's, which is 110 times the second difference, come near Table 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.factored_plant import FactoredPlant, factored
from fbfcli.control.fbf import filtered_from_rest
from fbfcli.control.inversion import Inverse, npz_ignore, zmetc, zpetc

POLE = 0.5
ZEROS = (1.1, -1.1)
SIDES = {1.1: "RHP", -1.1: "LHP"}
RATE = 10_000.0  # Hz
E = 500
DURATION = E / RATE  # s
DEGREE = 4
N = 200  # n: 201 control points
METHODS = {"NPZ-ignore": npz_ignore, "ZPETC": zpetc, "ZMETC": zmetc}

START = {"x": 10.0, "y": 5.0}  # mm
DISTANCE = {"x": 3.71, "y": 1.245}  # mm
MOVES = {"x": 3, "y": 4}


@dataclass(frozen=True)
class Plant:
    """G = b / a, coefficients of z^0, z^-1.

    b, a : ndarrays, shape (2,)
    """

    b: np.ndarray
    a: np.ndarray

    @property
    def state_space(self) -> tuple[float, float, float, float]:
        """A_d, B_d, C_d, D_d of Eq. 15 with B_d = 1."""
        p, gain = -self.a[1], self.b[0]
        return float(p), 1.0, float(self.b[1] + gain * p), float(gain)

    def factors(self) -> FactoredPlant:
        """Its zero is outside the circle: none is cancelled."""
        return factored(self.b, self.a)

    def inverses(self) -> dict[str, Inverse]:
        """The methods of Table 1."""
        return {name: method(self.factors()) for name, method in METHODS.items()}

    def filtered(self, Phi: np.ndarray) -> np.ndarray:
        """Basis functions behind the plant, from an initial state with y(0) = u(0)."""
        return filtered_from_rest(self.b, self.a, Phi)


def plant(zero: float) -> Plant:
    """Eq. 37."""
    K = (1 - POLE) / (1 - zero)
    return Plant(K * np.array([1.0, -zero]), np.array([1.0, -POLE]))


def time_ms() -> np.ndarray:
    """Of the samples."""
    return 1e3 * DURATION * normalised_time(E)


def basis(n: int, order: int = 0) -> np.ndarray:
    """Splines of degree 4, or their derivative by time of the given order [1/s^order], shape (E + 1, n + 1)."""
    return bsplines(normalised_time(E), n, DEGREE, order) / DURATION**order


def desired(axis: str, order: int = 0) -> np.ndarray:
    """Position of an axis [mm], or its derivative of order 1 or 2 [mm/s, mm/s^2], shape (E + 1,)."""
    t = normalised_time(E) * MOVES[axis]
    move = np.minimum(t.astype(int), MOVES[axis] - 1)
    s, sign = t - move, 1.0 - 2.0 * (move % 2)
    shape = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])  # minimum jerk
    y = DISTANCE[axis] * sign * shape.deriv(order)(s) * (MOVES[axis] / DURATION) ** order
    return np.asarray(y + (START[axis] + DISTANCE[axis] * (move % 2) if order == 0 else 0.0))


def lti_error(inverse: Inverse, y_d: np.ndarray) -> np.ndarray:
    """(1 - L) y_d where the axis rests before and after, shape (E + 1,)."""
    error = inverse.L.error()
    room = len(error.c)
    held = np.pad(y_d - y_d[0], room, mode="edge")
    return error.filtered(held)[room : room + len(y_d)]


def rms(x: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(x))))
