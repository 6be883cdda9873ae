"""Contour-weighted robust FBF: errors across the path count fully, along it little, over a family of plants.

A resonance is seldom known to 5 %, and what is seen on a part is the error normal to the path. FBF takes both: with the
squared error weighed by the path's own direction and averaged over the plants that the axes may be, the command is
still the solution of one banded least squares (`contour_window`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, pi

import numpy as np

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.contour_gram import contour_gram
from fbfcli.control.contour_window import ContourSolver
from fbfcli.control.limits import Box
from fbfcli.control.spline_design import ASSUMED_HZ, DEGREE, STEPS, checked_basis
from fbfcli.control.windows import SplineCompensator
from fbfcli.errors import ModelError

RHO = 0.1  # curvature weight: u'' of (w_n)^2 times a displacement costs this part of it as error
ALONG = 0.05  # weight of an error along the path, against 1 across it
PREVIEW = 24  # periods of the slowest mode: the command is within 0.01 um of one window's; with 6, within 1 um
KEPT = 2  # times the preview and the memory of a spline: so much of a window is kept
KNOTS = 0.3  # of the fastest mode's period, from knot to knot
INSIDE = 0.98  # of the limits: what the windows are held to, since they stop iterating within 1 %


def contour(axes: Sequence[AxisModel], dt: float, given: Mapping[str, float], box: Box | None,
            step: int = 0) -> SplineCompensator:  # fmt: skip
    """The compensator for X and Y.

    given : degree, L, rho or mu, wt, preview, n_C, n_up, lead, tail
    box   : limits of speed and acceleration that the command keeps
    step  : the curvature's weight is 10^step times what it would be

    Raises ModelError.
    """
    if len(axes) != 2:
        raise ModelError("contour compensates X and Y together: it needs the models of both")
    f = [mode[0] for axis in axes for mode in axis.modes] or [ASSUMED_HZ]
    m, L = int(given.get("degree", DEGREE)), int(given.get("L", max(2, round(KNOTS / (max(f) * dt)))))
    if m < 2:
        raise ModelError("contour weighs and bounds accelerations: a spline has them from degree 2 on")
    basis = checked_basis(m, L, given)
    gram = contour_gram(basis, *axes)
    w_n = 2 * pi * np.array([axis.modes[0][0] if axis.modes else ASSUMED_HZ for axis in axes])
    h = L * dt
    bend = 10.0**step * _curvature_weight(w_n, dt, given) * L / h**4
    preview = ceil(given.get("preview", PREVIEW / (min(f) * dt)) / L)
    kept = given["n_C"] - preview if "n_C" in given else KEPT * (preview + len(gram.xx))
    n_up = int(given.get("n_up", max(1, kept)))
    n_c = int(given.get("n_C", n_up + preview))
    limits = (box.velocity, box.acceleration) if box else (np.full(2, np.inf), np.full(2, np.inf))
    solver = ContourSolver(basis, gram, bend, given.get("wt", ALONG), n_c, n_up,
                           INSIDE * h * limits[0], INSIDE * h**2 * limits[1], (w_n * h) ** 2)  # fmt: skip
    hold = (m + 1) * L // 2
    harder = (lambda: contour(axes, dt, given, box, step + 1)) if step < STEPS else None
    return SplineCompensator("contour", basis, n_c, n_up, solver, harder, int(given.get("lead", hold)),
                             int(given.get("tail", hold)), within_windows=True)  # fmt: skip


def _curvature_weight(w_n: np.ndarray, dt: float, given: Mapping[str, float]) -> np.ndarray:
    """mu = (rho / w_n^2)^2 [s^4], shape (2,); a given mu counts second differences per sample, as for fbf."""
    if "mu" in given:
        return np.full(w_n.shape, given["mu"] * dt**4)
    return np.asarray((given.get("rho", RHO) / w_n**2) ** 2)
