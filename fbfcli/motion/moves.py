"""Straight moves as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.printer import Limits

X, Y, Z, E = range(4)
EPS_MM = 1e-9  # below one float step at bed scale: shorter moves are no motion


def moves_xy(moves: Moves) -> np.ndarray:
    """Moves of X or Y, bool, shape (n,)."""
    return (moves.delta[:, X] != 0.0) | (moves.delta[:, Y] != 0.0)


@dataclass(frozen=True)
class Moves:
    """Straight moves in order of execution; n of them.

    start  : ndarray, shape (n, 4)        X, Y, Z, E before the move, machine coordinates, E without resets [mm]
    delta  : ndarray, shape (n, 4)        displacement [mm]
    speed  : ndarray, shape (n,)          requested speed: along X, Y and Z, or along E where only E moves [mm/s]
    stop   : ndarray of bool, shape (n,)  the machine is at rest before this move, whatever the planner could do
    state  : ndarray of int, shape (n,)   index into `limits`: what is in force
    line   : ndarray of int, shape (n,)   line of the file that asked for it, counted from 0
    limits : tuple of Limits
    """

    start: np.ndarray
    delta: np.ndarray
    speed: np.ndarray
    stop: np.ndarray
    state: np.ndarray
    line: np.ndarray
    limits: tuple[Limits, ...]

    def __len__(self) -> int:
        return len(self.speed)

    def __getitem__(self, part: slice | np.ndarray) -> Moves:
        return Moves(self.start[part], self.delta[part], self.speed[part], self.stop[part], self.state[part],
                     self.line[part], self.limits)

    @property
    def distance(self) -> np.ndarray:
        """Length along X, Y, Z; along E where only E moves [mm], shape (n,)."""
        d = np.sqrt(self.delta[:, X]**2 + self.delta[:, Y]**2 + self.delta[:, Z]**2)
        return np.where(d > EPS_MM, d, np.abs(self.delta[:, E]))

    def limit(self, name: str, axis: int | None = None, part: slice | np.ndarray = slice(None)) -> np.ndarray:
        """One entry of the limits in force for each move, or for some: shape (n,), or (n, 4) where it has four."""
        state = self.state[part]
        first, last = (int(state.min()), int(state.max())) if len(state) else (0, 0)
        table = np.array([getattr(limits, name) for limits in self.limits[first:last + 1]])  # files can have 10,000s
        if axis is not None:
            table = table[:, axis]
        return np.repeat(table, len(state), axis=0) if len(table) == 1 else table[state - first]
