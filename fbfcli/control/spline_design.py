"""Spline methods that take each axis on its own: their default rules.

Evidence of the defaults. 16 stretches of 0.3 to 1.4 s planned at 5000 mm/s^2 and 200 mm/s,
dt = 1 ms, lpfbs; each entry is the tracking error RMS [um] / the largest |u''| over 5000 mm/s^2.
                   hold at the ends, rho = .1, L 4-6 ms       rho, hold 3 L           L, hold 24
plant              0         3 L       24        48           .03       .3            4         8         10
35/28 Hz           43/13.8   2.9/1.9   2.8/1.9   2.7/1.9      1.9/3.0   4.7/1.3       2.8/1.8   3.7/1.7   6.3/1.5
70/56 Hz           14/11.3   0.7/1.6   0.7/1.6   0.6/1.6      0.6/2.0   1.0/1.4       0.7/1.6   3.5/1.2   5.9/1.2
45+85/38+66 Hz     15/9.4    1.5/2.3   1.4/2.3   1.3/2.3      1.0/3.0   2.8/1.5       1.4/2.3   3.4/1.7   5.7/1.3
TAZ 6              39/15.8   7.6/3.0   7.2/1.9   6.9/1.9      4.7/4.8   12/1.4        7.2/2.0   7.4/2.4   9.2/2.5
HICTOP             46/13.6   3.4/2.4   2.9/1.8   2.1/1.8      3.2/2.8   4.1/1.9       2.6/1.8   4.1/1.5   7.7/1.2
So the command needs to move before and after the motion: half a spline's support, (m + 1) L / 2 samples, at each end.
It costs print time at every rest, so knots are as close as pays. On a sliced tower, contour error RMS [um] / |u''|:
TAZ 6 at rho .1 5.5/2.0, at .07 4.9/3.1, at .045 4.3/3.8; 35/28 Hz at rho .1 2.3/1.3, at .045 1.8/2.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, pi

import numpy as np

from fbfcli.control.axis_model import AxisModel
from fbfcli.control.basis import Basis, uniform_basis
from fbfcli.control.lpfbs import UNSTABLE, limited_preview
from fbfcli.control.robust_basis import robust_response
from fbfcli.control.spline_fbf import FullPreview, filtered_basis, forgetting
from fbfcli.control.windows import AxisByAxis, AxisSolver, SplineCompensator
from fbfcli.errors import ModelError

AXIS_BY_AXIS = ("lpfbs", "fbf", "robust", "robust_fbf")
DEGREE = 5
KNOT_S = 0.004  # between knots at most: wider ones need a longer hold
RHO = 0.045  # curvature weight: u'' of (w_n)^2 times a displacement costs this part of it as error
PREVIEW_S = 0.25  # of LPFBS at least: 10 / ln|z| at 1 ms for the TAZ 6's zeros z outside the unit circle
MOST_AHEAD = 400  # knots of preview where the robust filter begins early: 180 MB at L = 10; beyond, wider knots
LONGER = 1.5  # and this much longer as often as its recursion is not stable enough
ATTEMPTS = 6
N_C = (2048, 8192)  # coefficients that fbf solves at once, least and most: 150 MB an axis at Q = 2300
STEPS = 4  # times a compensator can be made ten times stiffer
ASSUMED_HZ = 30.0  # of an axis whose model has no oscillating mode

Modes = Sequence[tuple[float, float, float]]
Family = tuple[Sequence[np.ndarray], np.ndarray]  # impulse responses and their weights


def axis_by_axis(name: str, axes: Sequence[AxisModel], dt: float, given: Mapping[str, float],
                 step: int = 0) -> SplineCompensator:  # fmt: skip
    """The method of AXIS_BY_AXIS; `step` times its weight mu is raised tenfold.

    lpfbs      : limited preview, splines filtered by the nominal plant
    fbf        : the same with full preview
    robust     : limited preview, splines filtered by the robust filter of the family, Ramani 2020b Eq. 11
    robust_fbf : full preview, the expected squared error over the family: as robust, where splines can do all
    """
    ahead, splines = _filters(name, axes)
    wide = ceil((PREVIEW_S / dt + ahead) / MOST_AHEAD) if ahead else 0
    knots = max(knot_spacing([axis.modes for axis in axes], dt), wide)
    m, L = int(given.get("degree", DEGREE)), int(given.get("L", knots))
    basis = checked_basis(m, L, given)
    mu = [10.0**step * given.get("mu", curvature_weight(axis.modes, dt)) for axis in axes]
    early = np.zeros(-ahead % L)  # whole knots
    splines = [(tuple(np.concatenate((early, h)) for h in family), weights) for family, weights in splines]
    ahead += len(early)
    if name in ("lpfbs", "robust"):
        n_C, n_up, solvers = _limited(basis, splines, mu, ahead * dt, dt, given)
    else:
        n_C, n_up, solvers = _full(basis, splines, mu, given)
    hold = (basis.m + 1) * basis.L // 2
    harder = (lambda: axis_by_axis(name, axes, dt, given, step + 1)) if step < STEPS and max(mu) > 0 else None
    return SplineCompensator(name, basis, n_C, n_up, AxisByAxis(solvers), harder,
                             int(given.get("lead", hold)), int(given.get("tail", hold)), ahead)  # fmt: skip


def _filters(name: str, axes: Sequence[AxisModel]) -> tuple[int, list[Family]]:
    """What each axis' splines are filtered by, and how many samples all of that begins before the spline."""
    if name == "robust_fbf":
        return 0, [(axis.family, axis.weights) for axis in axes]
    if name != "robust":
        return 0, [((axis.h,), np.ones(1)) for axis in axes]
    responses = [robust_response(axis) for axis in axes]
    ahead = max(before for _, before in responses)
    return ahead, [((np.concatenate((np.zeros(ahead - before), h)),), np.ones(1)) for h, before in responses]


def checked_basis(m: int, L: int, given: Mapping[str, float]) -> Basis:
    """The basis, where it and the windows given make sense. Raises ModelError."""
    if m < 1 or L < 1 or not 1 <= given.get("n_up", 1) <= given.get("n_C", np.inf):
        raise ModelError(f"degree {m} and L {L} must be at least 1, n_up from 1 to n_C")
    return uniform_basis(m, L)


def knot_spacing(modes: Sequence[Modes], dt: float) -> int:
    """L: three knots and more per period of the fastest mode of any axis, KNOT_S apart at most, at least 2 samples."""
    fastest = max((mode[0] for axis in modes for mode in axis), default=ASSUMED_HZ)
    return max(2, round(min(0.3 / fastest, KNOT_S) / dt))


def curvature_weight(axis: Modes, dt: float) -> float:
    """mu = (RHO / (w_n dt)^2)^2, w_n of the axis' strongest mode: RHO whatever the period and the machine."""
    f = axis[0][0] if axis else ASSUMED_HZ
    return float((RHO / (2 * pi * f * dt) ** 2) ** 2)


def _limited(basis: Basis, filters: Sequence[Family], mu: Sequence[float], ahead: float, dt: float,
             given: Mapping[str, float]) -> tuple[int, int, Sequence[AxisSolver]]:  # fmt: skip
    """Windows that keep as many coefficients as they preview; the preview grows until errors die out within windows.

    ahead : time that filtered splines begin before their splines [s]: so much less of a window's samples is preview
    """
    preview = ceil(given.get("preview", (PREVIEW_S + ahead) / dt) / basis.L)
    for _ in range(ATTEMPTS):
        n_up = int(given.get("n_up", preview))
        n_C = int(given.get("n_C", n_up + preview))
        solvers = tuple(limited_preview(filtered_basis(basis, *filter_i, mu_i, n_C), mu_i, n_C, n_up)
                        for filter_i, mu_i in zip(filters, mu, strict=True))  # fmt: skip
        radius = max(solver.radius for solver in solvers)
        if radius < UNSTABLE:
            return n_C, n_up, solvers
        if given.keys() & {"n_C", "preview"}:
            break
        preview = ceil(LONGER * preview)
    raise ModelError(f"windows of {n_C} coefficients that keep {n_up} amplify their errors {radius:.3g} times per "
                     f"window (knots every {basis.L} samples): lengthen the preview or widen the knots")  # fmt: skip


def _full(basis: Basis, filters: Sequence[Family], mu: Sequence[float],
          given: Mapping[str, float]) -> tuple[int, int, Sequence[AxisSolver]]:  # fmt: skip
    """Windows long enough to keep a quarter of what they solve and not to feel the held future in what they keep."""
    n_C = int(given.get("n_C", N_C[0]))
    while True:
        bases = [filtered_basis(basis, *filter_i, mu_i, n_C) for filter_i, mu_i in zip(filters, mu, strict=True)]
        n_up = int(given.get("n_up", n_C - max(forgetting(full) for full in bases)))
        if n_up >= n_C // 4 or n_C >= N_C[1] or given.keys() & {"n_C", "n_up"}:
            break
        n_C *= 2
    if not 0 < n_up <= n_C:
        raise ModelError(f"windows of {n_C} coefficients feel their own ends: give n_C more than {n_C - n_up}")
    return n_C, n_up, tuple(FullPreview(full, n_C, n_up) for full in bases)
