"""What every compensator offers: one stretch from rest to rest at a time, commands given back as they become final."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Stream(Protocol):
    """One stretch from rest to rest, in order."""

    def push(self, y_d: np.ndarray, weight: np.ndarray, last: bool) -> np.ndarray:
        """Commands that are final now, shape (m, axes) [mm]; over a stretch as many as samples were pushed.

        y_d    : ndarray, shape (n, axes)   next samples of the desired position [mm]
        weight : ndarray, shape (n,)        importance of each sample; methods that work axis by axis ignore it
        last   : the stretch ends, at rest, with these samples

        The stretch's first command is its first desired position and the last its last, exactly, both at rest.
        """
        ...


class Compensator(Protocol):
    """A method designed for given plants; `start` makes a Stream for each stretch.

    lead, tail : hold a stretch needs before and after its motion [samples]
    settle     : a stretch of fewer samples is passed through: no command can move and rest within it [samples]
    preview    : desired positions ahead that a command may depend on [samples]
    notice     : samples that another design must be resumed with before those that it is meant for
    """

    @property
    def name(self) -> str: ...
    @property
    def lead(self) -> int: ...
    @property
    def tail(self) -> int: ...
    @property
    def settle(self) -> int: ...
    @property
    def preview(self) -> int: ...
    @property
    def notice(self) -> int: ...

    def start(self, y_0: np.ndarray) -> Stream:
        """A stretch whose command rests at y_0, shape (axes,) [mm], before it."""
        ...

    def resume(self, stream: Stream) -> Stream:
        """A stretch that this compensator, or a stiffer or softer one, has begun; `stream` stays as it is."""
        ...

    def stiffer(self) -> Compensator | None:
        """The same with ten times the weight on the command's curvature; None where there is none to raise."""
        ...


AT_REST = 4  # samples held at least: then the first and last segments are slow, and the corners to what is next too


class Uncompensated:
    """u = y_d."""

    name = "none"
    lead = tail = AT_REST
    settle = preview = notice = 0

    def start(self, y_0: np.ndarray) -> Uncompensated:
        """The stretch needs no memory: the compensator is its own stream."""
        return self

    def resume(self, stream: Stream) -> Stream:
        """Without memory there is nothing to copy."""
        return stream

    def stiffer(self) -> None:
        """There is no weight to raise."""

    def push(self, y_d: np.ndarray, weight: np.ndarray, last: bool) -> np.ndarray:
        """A copy of y_d."""
        return np.array(y_d, float)
