"""What a stream remembers of a stretch: the desired path that its coming commands depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Path:
    """Samples of a stretch's desired motion, relative to where it began.

    y      : ndarray, shape (axes, n)    position [mm]
    weight : ndarray, shape (n,)         importance of each sample
    models : tuple of (first sample, m)  what the plants are taken to be from each sample on; the first one's <= 0
    """

    y: np.ndarray
    weight: np.ndarray
    models: tuple[tuple[int, Any], ...]

    def __getitem__(self, samples: slice) -> Path:
        first, stop, _ = samples.indices(len(self.weight))
        begun = sum(start <= first for start, _ in self.models)
        models = tuple((start - first, m) for start, m in self.models[max(begun - 1, 0) :] if start < max(stop, 1))
        return Path(self.y[:, samples], self.weight[samples], models)

    def then(self, y: np.ndarray, weight: np.ndarray, model: object) -> Path:
        """This path and what comes after it, where the plants are taken to be `model`."""
        if not len(weight):
            return self
        goes_on = self.models[-1][1] is model
        models = self.models if goes_on else (*self.models, (len(self.weight), model))
        return Path(np.concatenate((self.y, y), axis=1), np.concatenate((self.weight, weight)), models)


def resting(axes: int, samples: int, model: object) -> Path:
    """A rest at the beginning, of so many samples."""
    return Path(np.zeros((axes, samples)), np.ones(samples), ((0, model),))
