"""Lifted systems are the systems: filters, recursions, and their norms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter, tf2ss

from fbfcli.control.lifted import (
    bound,
    causal,
    decoupled_bound,
    markov,
    metric,
    mimo,
    non_causal,
    observability,
    varying,
)

b, a = np.array([0.2, -0.5, 0.1]), np.array([1.0, -1.2, 0.5])
u = np.random.default_rng(3).standard_normal(40)


def test_a_causal_system_is_its_filter():
    np.testing.assert_allclose(causal(markov(b, a, 39)) @ u, lfilter(b, a, u), atol=1e-12)


@given(st.integers(0, 9), st.integers(1, 10), st.integers(0, 12))
def test_a_non_causal_system_is_its_convolution(origin, taps, M):
    origin = min(origin, taps - 1)
    c, x = np.arange(1.0, taps + 1), np.random.default_rng(M).standard_normal(M + 1)
    np.testing.assert_allclose(non_causal(c, origin, M) @ x, np.convolve(x, c)[origin : origin + M + 1], atol=1e-9)


def test_a_constant_state_space_is_the_causal_system():
    np.testing.assert_allclose(varying([tf2ss(b, a)] * 40), causal(markov(b, a, 39)), atol=1e-12)


def test_channels_interleave_samples():
    rng = np.random.default_rng(5)
    g = rng.standard_normal((2, 3, 6))
    G = mimo([[causal(g[o, p]) for p in range(3)] for o in range(2)])
    x = rng.standard_normal((6, 3))
    expected = [sum(np.convolve(g[o, p], x[:, p])[:6] for p in range(3)) for o in range(2)]
    np.testing.assert_allclose((G @ x.ravel()).reshape(6, 2).T, expected, atol=1e-12)


def test_several_channels_by_state_space_and_by_blocks_agree():
    one, two = tf2ss(b, a), tf2ss([0.3, 0.1], [1.0, -0.6])
    A = np.block([[one[0], np.zeros((2, 1))], [np.zeros((1, 2)), two[0]]])
    B = np.block([[one[1], np.zeros((2, 1))], [np.zeros((1, 1)), two[1]]])
    C, D = np.hstack((one[2], two[2])), np.hstack((one[3], two[3]))
    G = mimo([[causal(markov(b, a, 19)), causal(markov(np.array([0.3, 0.1]), np.array([1.0, -0.6]), 19))]])
    np.testing.assert_allclose(varying([(A, B, C, D)] * 20), G, atol=1e-12)


def test_an_initial_state_rings_as_observed():
    A, _, C, _ = tf2ss(b, a)
    x = np.array([0.7, -0.2])
    heard = [float((C @ np.linalg.matrix_power(A, k) @ x)[0]) for k in range(15)]
    np.testing.assert_allclose(observability(A, C, 14) @ x, heard, atol=1e-12)


def test_the_metric_is_the_system_norm_of_a_long_trajectory():
    """Ramani 2020 Eq. 2.20: ||E||_F / sqrt(M + 1) tends to the 2-norm of E(q)."""
    g = markov(b, a, 2000)
    assert metric(causal(g)) == pytest.approx(np.linalg.norm(g), rel=1e-3)


def test_no_output_is_beyond_the_bound_and_one_reaches_it():
    G = causal(markov(b, a, 39))
    worst = np.sign(G[np.abs(G).sum(axis=1).argmax()])
    assert np.abs(G @ worst).max() == pytest.approx(bound(G))
    assert np.abs(G @ np.clip(u, -1, 1)).max() <= bound(G)


def test_the_bound_by_functions_is_looser():
    Psi, Psi_f = np.random.default_rng(2).standard_normal((2, 30, 7))
    assert bound(Psi @ Psi_f.T) <= decoupled_bound(Psi, Psi_f)
