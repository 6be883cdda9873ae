"""What a compensator knows of one axis: its nominal plant, and the family of plants it may really be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class AxisModel:
    """One axis, as arrays; all responses have the same period and sum 1.

    b, a    : ndarray, shapes (nb,), (na,)    nominal plant, coefficients of z^0, z^-1, ...; a[0] = 1
    h       : ndarray, shape (n,)             its impulse response
    modes   : tuples                          (frequency [Hz], damping, weight) of its resonances, strongest first
    family  : tuple of ndarray, shapes (n_j,) impulse responses G_j of what the plant may be; (h,) where it is exact
    weights : ndarray, shape (J,)             probability lambda_j of each, sum 1
    """

    b: np.ndarray
    a: np.ndarray
    h: np.ndarray
    modes: tuple[tuple[float, float, float], ...]
    family: tuple[np.ndarray, ...]
    weights: np.ndarray


def exactly(b: np.ndarray, a: np.ndarray, h: np.ndarray, modes: Sequence[tuple[float, float, float]]) -> AxisModel:
    """The axis whose plant is known: a family of one."""
    return AxisModel(b, a, h, tuple(modes), (h,), np.ones(1))
