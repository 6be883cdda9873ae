"""Who wants to see more of a simulation than its figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from fbfcli.verify.passage import Passage


class Watcher(Protocol):
    """Told, method after method, what the machine draws as it is modelled; verify.traces.Traces is one."""

    def begin(self, name: str, features: Sequence[str]) -> None:
        """A method begins; names of what is printed, by number: more may come while the file is read."""

    def add(self, name: str, passage: Passage) -> None:
        """More of what the machine makes of a method."""

    def segments(self, name: str, starts: np.ndarray) -> None:
        """More written segments: when each begins, shape (k,), since the print began [s]."""

    def load(self, name: str, time: np.ndarray, share: np.ndarray, motors: Sequence[str]) -> None:
        """More of the motors' loads: share (n, m) of the torque that each of m motors has, at time (n,) [s]."""
