"""Bases that are best for a plant: no effort is smaller, none is less disturbed, and sizes are what is asked."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import svdvals

from fbfcli.control.bases import block_pulses, dct
from fbfcli.control.fbf import decoupled
from fbfcli.control.lifted import causal, markov, metric
from fbfcli.control.lifted_robust import lti_family
from fbfcli.control.optimal_basis import (
    accuracy,
    effort_optimal,
    effort_optimal_weighted,
    least_effort,
    robust_basis,
    size_for,
)
from fbfcli.errors import ControlError

M = 80


def plant(a: float, p: float = 0.5) -> np.ndarray:
    return causal(markov(np.array([1.0, -a]), np.array([1.0, -p]), M))


@pytest.mark.parametrize("a", [-5.0, -1.0, 0.3, 1.0, 1.02, 5.0])
@pytest.mark.parametrize("n", [5, 40, 75])
def test_no_basis_costs_less(a, n):
    """Ramani 2020 Prop. 3.1, against cosines, pulses and functions drawn at random."""
    G = plant(a)
    best = effort_optimal(G, n)
    np.testing.assert_allclose(G @ best.Psi, best.Psi_f, atol=1e-10)
    np.testing.assert_allclose(best.Psi_f.T @ best.Psi_f, np.eye(n + 1), atol=1e-10)
    J_c = metric(best.C)
    assert J_c == pytest.approx(least_effort(svdvals(G), n))
    for Phi in (dct(M, n), block_pulses(M, n), np.random.default_rng(n).standard_normal((M + 1, n + 1))):
        assert J_c <= metric(decoupled(Phi, G @ Phi).C) * (1 + 1e-9)


@given(st.integers(0, 500), st.integers(1, 500))
def test_the_size_for_an_accuracy_is_the_least(n, more):
    last = n + more
    assert size_for(accuracy(n, last), last) == n
    between = (accuracy(n, last) + accuracy(n + 1, last)) / 2
    assert size_for(between, last) == n + 1


def test_a_weight_puts_the_accuracy_where_it_counts():
    """Remark 3.3: with few functions, a slow trajectory is met better by the basis that knows it is slow."""
    G, n = plant(1.1), 15
    F = causal(markov(np.array([0.1]), np.array([1.0, -0.9]), M))
    y_d = np.sin(2 * np.pi * np.arange(M + 1) / M) ** 2
    u = effort_optimal_weighted(G, F, n).command(F @ y_d)
    plain = effort_optimal(G, n).command(y_d)
    assert np.linalg.norm(F @ (y_d - G @ u)) < 0.5 * np.linalg.norm(F @ (y_d - G @ plain))


def uncertain() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Markov parameters of a family, its weights, and a nominal plant among it."""
    zeros = np.linspace(0.9, 1.4, 7)
    g = np.stack([markov(np.array([0.0, 1.0, -a]), np.array([1.0, -0.9, 0.3]), M) for a in zeros])
    return g, np.full(7, 1 / 7), causal(g[3])


@pytest.mark.parametrize("n", [3, 30, 70])
def test_no_basis_is_less_disturbed(n):
    """Ramani 2020 Prop. 4.2 among bases that keep off the r smallest singular values."""
    g, weights, G = uncertain()
    family = lti_family(g, weights)
    robust = robust_basis(G, family.root(G), r=2)
    J = family.metric(robust.controller(n))
    assert pytest.approx(robust.metric(n), rel=1e-6) == J
    assert family.metric(effort_optimal(G, n)) * (1 + 1e-9) >= J
    kept = effort_optimal(G, M - 2).Psi
    for seed in range(5):
        Phi = kept @ np.random.default_rng(seed).standard_normal((M - 1, n + 1))
        assert family.metric(decoupled(Phi, G @ Phi)) * (1 + 1e-9) >= J


def test_the_best_size_is_where_the_metric_is_least():
    """Remark 4.5, scenario iii."""
    g, weights, G = uncertain()
    robust = robust_basis(G, lti_family(g, weights).root(G), r=2)
    assert 1 < robust.best_size() < M - 2
    assert robust.best_size() == np.argmin([robust.metric(n) for n in range(len(robust.sigma))])


def test_bad_questions_are_refused():
    g, weights, G = uncertain()
    robust = robust_basis(G, lti_family(g, weights).root(G), r=2)
    for ask in (lambda: effort_optimal(G, M + 1), lambda: size_for(1.0, M), lambda: robust.controller(M - 1),
                lambda: robust_basis(G, G, M + 1)):  # fmt: skip
        with pytest.raises(ControlError):
            ask()
