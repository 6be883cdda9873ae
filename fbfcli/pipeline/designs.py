"""What is known of X and Y wherever the print is: plants and compensators, made when it gets there.

A printer whose models hold everywhere has one place, 0. Else the models change with position and printed mass, and
places are told apart in SHARES steps from one model to the next: 0.6 % of a frequency that changes by 20 %.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi

import numpy as np

from fbfcli.control.axis_model import AxisModel, exactly
from fbfcli.control.compensator import Compensator
from fbfcli.control.design import design
from fbfcli.control.limits import Box
from fbfcli.control.windows import SplineCompensator
from fbfcli.errors import ProfileError
from fbfcli.motion.moves import E
from fbfcli.pipeline.choice import FAMILY_METHODS, uncertainty_of
from fbfcli.pipeline.settings import Settings
from fbfcli.plant.model import BA, Plant, Vibration, cut, impulse_response, modes, plant_of
from fbfcli.plant.places import between, shares
from fbfcli.plant.uncertainty import Members, members
from fbfcli.printer import Axis, Model, Printer

SHARES = 32  # steps of a model's share
WINDOWED = ("lpfbs", "robust")  # keep little of each window where X and Y change the model within a second
EVERY = 100  # samples: a tenth of a second at 1 ms, 30 mm at 300 mm/s

Shares = tuple[tuple[float, ...], ...]


class Designs:
    """Plants and compensators of one print."""

    def __init__(self, printer: Printer, method: str, settings: Settings):
        self.method, self._printer, self._settings = method, printer, settings
        self.box = box_of(printer)
        self.vary = any(axis.at for axis in self._axes)  # along the print
        self._options = dict(settings.options)
        self._numbers: dict[Shares, int] = {((), ()): 0}  # place 0 has the nominal models
        self._levels: list[list[Compensator]] = []
        self._plants: list[tuple[Plant, Plant]] = []
        self._means: dict[int, tuple[BA, BA]] = {}
        self._families: dict[tuple[str, tuple[float, ...]], Members] = {}
        if self.vary:
            self._options |= self._shared()
        self._kg_per_mm = printer.filament_density * pi * (printer.filament_diameter / 2) ** 2

    def places(self, x: np.ndarray) -> np.ndarray:
        """Number of the place of each sample, shape (n,); x (n, 4) is X Y Z E [mm], E without resets."""
        if not self.vary:
            return np.zeros(len(x), dtype=np.int64)
        here = x[::EVERY].copy()
        here[:, E] = np.maximum(here[:, E], 0.0) * self._kg_per_mm
        found = [_steps(shares(axis.at, here)) if axis.at else np.zeros((len(here), 0)) for axis in self._axes]
        rows = [tuple(map(tuple, row)) for row in zip(*(each.tolist() for each in found), strict=True)]
        numbers = [self._numbers.setdefault(row, len(self._numbers)) for row in rows]
        return np.repeat(np.array(numbers, dtype=np.int64), EVERY)[: len(x)]

    def compensator(self, place: int, level: int = 0) -> Compensator:
        """The method designed for a place, made `level` times stiffer, or as stiff as it gets."""
        while len(self._levels) <= place:
            self._levels.append([self._designed(self._shares(len(self._levels)))])
        levels = self._levels[place]
        while len(levels) <= level and (stiffer := levels[-1].stiffer()) is not None:
            levels.append(stiffer)
        return levels[min(level, len(levels) - 1)]

    def plants(self, place: int) -> tuple[Plant, Plant]:
        """Plants of X and Y at a place."""
        while len(self._plants) <= place:
            share_x, share_y = self._shares(len(self._plants))
            self._plants.append((self._plant(self._axes[0], share_x), self._plant(self._axes[1], share_y)))
        return self._plants[place]

    def models(self, place: int) -> tuple[Model, Model]:
        """Models of X and Y at a place."""
        share_x, share_y = self._shares(place)
        return self._model(self._axes[0], share_x), self._model(self._axes[1], share_y)

    def families(self, place: int) -> tuple[Members, Members]:
        """What X and Y may really be at a place, as the settings or the profile say."""
        x, y = (self._family(axis, share) for axis, share in zip(self._axes, self._shares(place), strict=True))
        return x, y

    def b_a(self, place: int) -> tuple[BA, BA]:
        """Their coefficients."""
        x, y = self.plants(place)
        return (x.b, x.a), (y.b, y.a)

    def mean(self, place: int) -> tuple[BA, BA]:
        """Mean plants of the families that the method knows: where the nozzle is to be expected."""
        if place not in self._means:
            x, y = (self._mean(axis, share) for axis, share in zip(self._axes, self._shares(place), strict=True))
            self._means[place] = x, y
        return self._means[place]

    @property
    def _axes(self) -> tuple[Axis, Axis]:
        return self._printer.axes[0], self._printer.axes[1]

    def _shares(self, place: int) -> Shares:
        """What part each of an axis' models has in a place; nothing where the nominal one holds."""
        return list(self._numbers)[place]

    def _designed(self, shares: Shares) -> Compensator:
        axes = [self._known(axis, share) for axis, share in zip(self._axes, shares, strict=True)]
        return design(self.method, axes, self._settings.dt, self._options, self.box)

    def _known(self, axis: Axis, share: tuple[float, ...]) -> AxisModel:
        """An axis as a compensator knows it."""
        plant = self._plant(axis, share)
        h = impulse_response(plant)
        if self._settings.fir is not None:
            h = cut(h, self._settings.fir)
        known = exactly(plant.b, plant.a, h, self._shaped(axis, modes(plant)))
        if self.method not in FAMILY_METHODS:
            return known
        family = self._family(axis, share)
        return replace(known, family=tuple(map(impulse_response, family.plants)), weights=family.weights)

    def _shaped(self, axis: Axis, found: tuple[Vibration, ...]) -> tuple[Vibration, ...]:
        """The modes, before them what the settings say that a shaper of the axis is made for."""
        if self._settings.shaped is None or not found:
            return found
        frequency = self._settings.shaped[self._axes.index(axis)]
        return (Vibration(frequency, found[0].damping, inf), *found)

    def _mean(self, axis: Axis, share: tuple[float, ...]) -> BA:
        if self.method not in FAMILY_METHODS:
            plant = self._plant(axis, share)
            return plant.b, plant.a
        return self._family(axis, share).mean(), np.ones(1)

    def _family(self, axis: Axis, share: tuple[float, ...]) -> Members:
        if (axis.name, share) not in self._families:
            uncertainty = uncertainty_of(axis, self._settings)
            found = members(self._model(axis, share), uncertainty, self._settings.dt, axis.name)
            self._families[axis.name, share] = found
        return self._families[axis.name, share]

    def _plant(self, axis: Axis, share: tuple[float, ...]) -> Plant:
        return plant_of(self._model(axis, share), self._settings.dt, axis.name)

    def _model(self, axis: Axis, share: tuple[float, ...]) -> Model:
        if not share:
            if axis.model is None:
                where = f"axis {axis.name} has no model"
                raise ProfileError(f"{self._printer.name}: {where} (write [axis.{axis.name}.model])")
            return axis.model
        return between([place.model for place in axis.at], share, self._settings.dt, axis.name)

    def _shared(self) -> dict[str, float]:
        """Options that let all designs of a print go on with each other's stretches: one basis, the finest."""
        x, y = (np.eye(max(1, len(axis.at))).tolist() if axis.at else [()] for axis in self._axes)
        ends = [(tuple(x[min(i, len(x) - 1)]), tuple(y[min(i, len(y) - 1)])) for i in range(max(len(x), len(y)))]
        designs = [self._designed(shares) for shares in ends]
        bases = [each.basis for each in designs if isinstance(each, SplineCompensator)]
        if not bases:
            return {}
        L = min(basis.L for basis in bases)
        crosses = any(place.x is not None or place.y is not None for axis in self._axes for place in axis.at)
        kept = {"n_up": max(1, round(EVERY / L))} if crosses and self.method in WINDOWED else {}
        return {"L": L, **kept}


def _steps(share: np.ndarray) -> np.ndarray:
    """Shares in steps, rows sum to 1."""
    steps = np.rint(SHARES * share)
    return steps / steps.sum(axis=1, keepdims=True)


def box_of(printer: Printer) -> Box:
    """What X and Y may be commanded."""
    axes = printer.axes[:2]
    return Box(
        low=np.array([axis.travel[0] for axis in axes]),
        high=np.array([axis.travel[1] for axis in axes]),
        velocity=np.array([axis.command_velocity for axis in axes]),
        acceleration=np.array([axis.command_acceleration for axis in axes]),
    )
