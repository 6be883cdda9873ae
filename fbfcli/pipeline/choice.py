"""Which method compensates a print, for which family of plants, and why."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from fbfcli.pipeline.settings import AUTO, Settings
from fbfcli.plant.model import modes, plant_of
from fbfcli.plant.uncertainty import ASSUMED, ASSUMED_AT
from fbfcli.printer import Axis, Family, Printer, Spread

# Half a range of frequency in which lpfbs is still nearer to the path than contour is. Error across the path RMS [um],
# lpfbs/contour, machines spread evenly over the range (python benchmarks/choice_rule.py):
#                   1 %        2 %        3 %        5 %
# 35/28 Hz          3.0/6.1    4.3/6.7    5.7/7.3    9.0/8.5
# 45/36 Hz          1.9/3.7    2.6/4.0    3.6/4.5    5.6/5.2
# 45+85/38+66 Hz    2.1/3.1    2.8/3.3    3.8/3.7    5.9/4.4
# TAZ 6/HICTOP      5.9/6.2    6.7/6.8    7.8/7.7    10.4/9.8
# 70/56 Hz          1.0/1.6    1.3/1.7    1.6/1.9    2.3/2.2
EXACT = {"one mode": 0.03, "several modes": 0.02}
ROUNDING = 1e-9
FAMILY_METHODS = ("robust", "robust_fbf", "contour")  # know the family, not the nominal plant alone


@dataclass(frozen=True)
class Choice:
    """The method, and one sentence for people."""

    method: str
    why: str


def uncertainty_of(axis: Axis, settings: Settings) -> Spread | Family:
    """How far an axis may be from its model: the settings say, or the profile, or nobody."""
    if settings.spread is not None:
        return Spread(frequency=(1.0 - settings.spread, 1.0 + settings.spread))
    if axis.uncertainty is not None:
        return axis.uncertainty
    return ASSUMED_AT if axis.at else ASSUMED


def chosen(printer: Printer, settings: Settings) -> Choice:
    """The method of the settings, or the one that the rule gives.

    The rule: models of both axes within EXACT of the truth are inverted as they are, by lpfbs; else the error across
    the path is kept small for the whole family, by contour. Raises ModelError, ProfileError.
    """
    axes = printer.axes[:2]
    told = _told(axes, settings)
    changes = _changes(axes)
    if settings.method != AUTO:
        return Choice(settings.method, _joined(told if settings.method in FAMILY_METHODS else "", changes))
    kinds = [_kind(axis, settings.dt) for axis in axes]
    half = [_half_range(uncertainty_of(axis, settings)) for axis in axes]
    if all(h <= EXACT[kind] + ROUNDING for h, kind in zip(half, kinds, strict=True)):
        return Choice("lpfbs", _joined(f"{told}: near enough, with {' and '.join(dict.fromkeys(kinds))}", changes))
    return Choice("contour", _joined(told, changes))


def _kind(axis: Axis, dt: float) -> str:
    """An entry of EXACT."""
    if axis.model is None:
        return "one mode"
    return "several modes" if len(modes(plant_of(axis.model, dt, axis.name))) > 1 else "one mode"


def _half_range(uncertainty: Spread | Family) -> float:
    """How far a frequency may be off; of named models, beyond any range unless there is but one."""
    if isinstance(uncertainty, Family):
        return 0.0 if len(uncertainty.models) == 1 else inf
    low, high = uncertainty.frequency
    return max(1.0 - low, high - 1.0)


def _joined(*words: str) -> str:
    return "; ".join(filter(None, words))


def _changes(axes: tuple[Axis, ...]) -> str:
    """Which models change along the print and with what, for people."""
    told = []
    for axis in axes:
        with_what = [name for name in ("x", "y", "z", "mass") if axis.at and getattr(axis.at[0], name) is not None]
        told += [f"the model of {axis.name} changes with {' and '.join(with_what)}"] if with_what else []
    return ", ".join(told)


def _told(axes: tuple[Axis, ...], settings: Settings) -> str:
    """How far the models are taken to be off, for people."""
    ranges = {axis.name: _range(uncertainty_of(axis, settings)) for axis in axes}
    same = len(set(ranges.values())) == 1
    words = ranges[axes[0].name] if same else ", ".join(f"{name} {words}" for name, words in ranges.items())
    if settings.spread is not None:
        return f"models taken to be {words}, as asked for"
    if all(axis.uncertainty is None for axis in axes):
        return f"the profile does not say how exact its models are: taken to be {words}"
    return f"models {words}, says the profile"


def _range(uncertainty: Spread | Family) -> str:
    if isinstance(uncertainty, Family):
        return f"one of {len(uncertainty.models)}"
    low, high = uncertainty.frequency
    return f"{100 * (low - 1):+.0f} to {100 * (high - 1):+.0f} % off in frequency" if high > low else "exact"
