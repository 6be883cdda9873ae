"""What a stream remembers of a stretch: the desired path that its coming commands depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Path:
    """Samples of a stretch's desired motion, relative to where it began.

    y      : ndarray, shape (axes, n)   position [mm]
    weight : ndarray, shape (n,)        importance of each sample
    """

    y: np.ndarray
    weight: np.ndarray

    def __getitem__(self, samples: slice) -> Path:
        return Path(self.y[:, samples], self.weight[samples])

    def then(self, other: Path) -> Path:
        """This path and the one after it."""
        return Path(np.concatenate((self.y, other.y), axis=1), np.concatenate((self.weight, other.weight)))


def resting(axes: int, samples: int) -> Path:
    """A rest at the beginning, of so many samples."""
    return Path(np.zeros((axes, samples)), np.ones(samples))
