"""A family's moments say what simulating every member says; the optimal nominal model is optimal."""

from __future__ import annotations

import numpy as np
import pytest

from fbfcli.control.bases import dct
from fbfcli.control.fbf import decoupled, decoupled_in_order
from fbfcli.control.lifted import causal, markov, metric, varying
from fbfcli.control.lifted_robust import Family, family, lti_family
from fbfcli.errors import ControlError

M = 60
ZEROS = (0.2, 0.4, 0.7)
g = np.stack([markov(np.array([1.0, -a]), np.array([1.0, -0.5]), M) for a in ZEROS])
weights = np.array([0.2, 0.3, 0.5])
plants = np.stack([causal(each) for each in g])


def test_moments_by_diagonals_are_the_moments():
    by_diagonals, dense = lti_family(g, weights), family(plants, weights)
    np.testing.assert_allclose(by_diagonals.mean, dense.mean, atol=1e-12)
    np.testing.assert_allclose(by_diagonals.second, dense.second, atol=1e-12)


def test_the_metric_is_the_mean_over_the_members():
    """Ramani 2020 Eq. 4.2 member by member, and Eq. 4.5 by the spread."""
    each, Phi = lti_family(g, weights), dct(M, 25)
    fbf = decoupled_in_order(Phi, plants[1] @ Phi)
    direct = np.sqrt(sum(w * metric(np.eye(M + 1) - G @ fbf.C) ** 2 for w, G in zip(weights, plants, strict=True)))
    assert each.metric(fbf) == pytest.approx(direct)
    assert each.nested_metrics(fbf)[-1] == pytest.approx(direct)
    disturbed = np.linalg.norm(each.root(plants[1]) @ fbf.Psi) ** 2 / (M + 1)
    assert np.sqrt(1 - 26 / (M + 1) + disturbed) == pytest.approx(direct)


def test_nested_metrics_are_those_of_the_smaller_controllers():
    each, Phi = lti_family(g, weights), dct(M, 25)
    nested = each.nested_metrics(decoupled_in_order(Phi, plants[0] @ Phi))
    for n in (0, 7, 20):
        assert nested[n] == pytest.approx(each.metric(decoupled(Phi[:, : n + 1], plants[0] @ Phi[:, : n + 1])))


def cost(each: Family, G_nom: np.ndarray) -> float:
    """J of Ramani 2020 Eq. 4.26: trace of G_nom^-T Delta^T Delta G_nom^-1."""
    inverse = np.linalg.inv(G_nom)
    return float(np.trace(inverse.T @ each.spread(G_nom) @ inverse))


def test_the_optimal_nominal_model_is_a_minimum():
    each = lti_family(g, weights)
    best = each.optimal_nominal()
    least = cost(each, best)
    rng = np.random.default_rng(0)
    for _ in range(10):
        nearby = best + 1e-3 * rng.standard_normal(best.shape)
        assert cost(each, nearby) > least
    assert least < min(cost(each, G) for G in plants)


def test_a_family_of_one_has_itself_as_optimal_nominal_model():
    np.testing.assert_allclose(lti_family(g[:1], np.ones(1)).optimal_nominal(), plants[0], atol=1e-9)


def test_varying_plants_make_a_family_too():
    """Remark 4.6: lifted, the nominal model need not be time invariant."""
    rng = np.random.default_rng(4)
    one = [np.stack([varying([(np.array([[p]]), np.eye(1), np.eye(1), np.eye(1)) for p in rng.uniform(0.2, 0.6, 20)])])
           for _ in range(4)]  # fmt: skip
    each = family(np.concatenate(one), np.full(4, 0.25))
    best = each.optimal_nominal()
    Phi = dct(19, 15)
    robust, member = (each.metric(decoupled(Phi, G @ Phi)) for G in (best, one[0][0]))
    assert robust < member


def test_weights_must_be_probabilities():
    with pytest.raises(ControlError, match="sum 1"):
        family(plants, np.ones(3))
