"""What the command of one axis adds to the other: a filter without DC gain."""

from __future__ import annotations

import numpy as np

from fbfcli.errors import ModelError
from fbfcli.plant.model import BA, MARGINAL, coefficients
from fbfcli.printer import ModalModel, Printer, TransferFunction


def coupling(printer: Printer, dt: float) -> tuple[BA | None, BA | None]:
    """(b, a) from Y's command to X, and from X's to Y, at period `dt` [s]; None where there is none.

    Raises ModelError where one does not decay.
    """
    x, y = (None if axis.coupling is None else _filter(axis.coupling, dt, axis.name) for axis in printer.axes[:2])
    return x, y


def _filter(model: ModalModel | TransferFunction, dt: float, axis: str) -> BA:
    b, a = coefficients(model, dt, axis)
    modulus = float(np.abs(np.roots(a)).max(initial=0.0))
    if not (np.isfinite(b).all() and modulus < 1.0 - MARGINAL):
        raise ModelError(
            f"axis {axis}: its coupling does not decay (a pole of modulus {modulus:.6f}): check its damping"
        )
    return b - b.mean(), a
