"""A shape that was fitted, and which of several is taken: what the data say for a model and what its size costs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fbfcli.plant.shape import Shape

# of the criterion: "very strong" evidence (Kass & Raftery 1995); less does not pay for a larger model
DECISIVE = 10.0


@dataclass(frozen=True)
class Candidate:
    """One shape, fitted: theta, its cost, and what the criterion says of it.

    theta     : ndarray, shape (shape.size,)
    residual  : complex ndarray, shape (m,)     measured minus model, over each line's standard deviation
    derivatives : complex ndarray, shape (m, size)   of the model, over the same
    misfit    : float                           rms of measured minus model, of the rms measured
    criterion : float                           Bayesian information criterion: smaller is better
    akaike    : float                           Akaike's, which asks less of a parameter: for what cannot be ruled out
    """

    shape: Shape
    theta: np.ndarray
    residual: np.ndarray
    derivatives: np.ndarray
    misfit: float
    criterion: float = float("nan")
    akaike: float = float("nan")


def chosen_first(found: list[Candidate]) -> tuple[Candidate, ...]:
    """The smallest of those within DECISIVE of the best, then the others; `found`: by criterion."""
    if not found:
        return ()
    enough = [c for c in found if c.criterion <= found[0].criterion + DECISIVE]
    chosen = min(enough, key=lambda c: (c.shape.size, c.criterion))
    return chosen, *(c for c in found if c is not chosen)


def ranked(found: list[Candidate]) -> list[Candidate]:
    """By BIC = N ln(cost / N) + k ln N; N counts only independent residuals, as those of the closest fit correlate."""
    if not found:
        return []
    closest = min(found, key=lambda c: float(np.vdot(c.residual, c.residual).real))
    N = 2 * len(closest.residual) / correlation_length(closest.residual)
    judged = []
    for c in found:
        misfit = float(N * np.log(np.mean(np.abs(c.residual) ** 2) / 2))
        judged.append(replace(c, criterion=misfit + c.shape.size * float(np.log(N)), akaike=misfit + 2 * c.shape.size))
    return sorted(judged, key=lambda c: c.criterion)


def correlation_length(residual: np.ndarray, most: int = 10) -> float:
    """Lines that say the same: 1 + 2 sum rho_k while neighbouring residuals correlate, at least 1.

    The nearest always count, for a window's lines share some bins: to leave out what is not significant by itself
    would make short responses surer than they are.
    """
    total, power = 1.0, np.vdot(residual, residual).real
    for lag in range(1, min(most, len(residual) // 4)):
        rho = float(np.vdot(residual[:-lag], residual[lag:]).real / power)
        if lag > 1 and rho < 2 / np.sqrt(len(residual)):
            break
        total += 2 * max(rho, 0.0)
    return total
