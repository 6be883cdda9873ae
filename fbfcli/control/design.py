"""Every method by its name: from what is known of each axis to a compensator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.compensator import Compensator, Uncompensated
from fbfcli.control.contour import contour
from fbfcli.control.inverse_stream import INVERSION_METHODS, INVERSION_OPTIONS, inverse
from fbfcli.control.limits import Box
from fbfcli.control.shapers import MAX_DAMPING, shaper
from fbfcli.control.spline_design import AXIS_BY_AXIS, axis_by_axis
from fbfcli.errors import ModelError

METHODS = ("none", *MAX_DAMPING, *AXIS_BY_AXIS, "contour", *INVERSION_METHODS)
OPTIONS = ("degree", "L", "mu", "rho", "wt", "n_C", "n_up", "lead", "tail", "frequency", "damping", *INVERSION_OPTIONS)


def design(name: str, axes: Sequence[AxisModel], dt: float,
           options: Mapping[str, float] | None = None, box: Box | None = None) -> Compensator:  # fmt: skip
    """The compensator called `name`, one of METHODS.

    axes    : one AxisModel per axis, of period dt [s]
    options : degree, L (samples between knots), mu, preview [samples], n_C, n_up, lead, tail of the spline methods;
              rho, wt of contour; frequency, damping of shapers; terms, preview, zero_damping, smooth of inverses
    box     : limits that contour keeps; the other methods have none

    Raises ModelError where the method cannot work on the plant, ValueError for an unknown name or option.
    """
    given = dict(options or {})
    if name not in METHODS or not given.keys() <= set(OPTIONS):
        raise ValueError(f"unknown method or option in {name!r}, {sorted(given)}: methods {METHODS}, options {OPTIONS}")
    if name == "none":
        return Uncompensated()
    if name in MAX_DAMPING:
        return shaper(name, [_shaped(axis, given) for axis in axes], dt)
    if name in INVERSION_METHODS:
        return inverse(name, axes, dt, given)
    if name == "contour":
        return contour(axes, dt, given, box)
    return axis_by_axis(name, axes, dt, given)


def _shaped(axis: AxisModel, given: Mapping[str, float]) -> tuple[float, float]:
    """Frequency and damping that an axis' shaper is made for."""
    if not axis.modes and not {"frequency", "damping"} <= given.keys():
        raise ModelError("a shaper needs an oscillating mode and the model has none; take lpfbs, or give its frequency")
    f, zeta = axis.modes[0][:2] if axis.modes else (0.0, 0.0)
    return given.get("frequency", f), given.get("damping", zeta)
