"""Which method compensates a print, for which family of plants, and why."""

from __future__ import annotations

from dataclasses import dataclass

from fbfcli.pipeline.settings import AUTO, Settings
from fbfcli.plant.uncertainty import ASSUMED
from fbfcli.printer import Axis, Family, Printer, Spread

EXACT = 0.02  # half a range of frequency: in a narrower one lpfbs is nearer to the path than contour is
FAMILY_METHODS = ("robust", "contour")  # know the family, not the nominal plant alone


@dataclass(frozen=True)
class Choice:
    """The method, and one sentence for people."""

    method: str
    why: str


def uncertainty_of(axis: Axis, settings: Settings) -> Spread | Family:
    """How far an axis may be from its model: the settings say, or the profile, or nobody."""
    if settings.spread is not None:
        return Spread(frequency=(1.0 - settings.spread, 1.0 + settings.spread))
    return ASSUMED if axis.uncertainty is None else axis.uncertainty


def chosen(printer: Printer, settings: Settings) -> Choice:
    """The method of the settings, or the one that the rule gives.

    The rule: models within EXACT of the truth on every axis are inverted as they are, by lpfbs; else the error across
    the path is kept small for the whole family, by contour. With one mode or several, contour is nearer to the path
    than any shaper as soon as a frequency is off by some per cent, so their number does not matter.
    """
    axes = printer.axes[:2]
    told = _told(axes, settings)
    if settings.method != AUTO:
        return Choice(settings.method, told if settings.method in FAMILY_METHODS else "")
    if all(_is_exact(uncertainty_of(axis, settings)) for axis in axes):
        return Choice("lpfbs", f"{told}: exact enough to be inverted as it is")
    return Choice("contour", told)


def _is_exact(uncertainty: Spread | Family) -> bool:
    if isinstance(uncertainty, Family):
        return len(uncertainty.models) == 1
    low, high = uncertainty.frequency
    return max(1.0 - low, high - 1.0) <= EXACT


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
