"""Numbers of Ramani 2020 that need no sweep: the metrics' formulas, the family of oscillators, the movable zero."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from fbfcli.control.lifted import causal, metric, non_causal
from fbfcli.control.lifted_robust import family
from fbfcli.papers.oscillators import DT, M, oscillator, realisations
from fbfcli.papers.ramani_2018 import error_dynamics
from fbfcli.papers.ramani_2020_stages import TAZ6_A, TAZ6_B, stage
from fbfcli.papers.ramani_2020_tables_4 import _second_order
from fbfcli.papers.zero_sweep import series_metric, zeros, zpetc_metric


def test_the_family_is_a_zero_order_hold():
    w, zeta = 2 * np.pi * 190.0, 0.02
    b, a, _ = cont2discrete(([w**2], [1, 2 * zeta * w, w**2]), DT)
    expected = lfilter(b[0], a, np.eye(1, M + 1)[0])
    np.testing.assert_allclose(oscillator(np.array([190.0]), np.array([zeta]))[0], expected, atol=1e-10)


def test_the_family_has_410_plants_with_damping_spaced_in_its_logarithm():
    g = realisations()
    assert g.shape == (410, M + 1)
    np.testing.assert_allclose(g[41 * 9 + 40], oscillator(np.array([220.0]), np.array([0.1]))[0])
    middle = oscillator(np.array([180.0]), np.array([1e-3 * 100 ** (4 / 9)]))[0]
    np.testing.assert_allclose(g[41 * 4], middle)


def test_a_plant_from_its_first_samples_is_the_plant():
    g = realisations()[100]
    u = np.random.default_rng(0).standard_normal((3, M + 1))
    np.testing.assert_allclose(_second_order(g, u), u @ causal(g).T, atol=1e-8)


@pytest.mark.parametrize("a", [-5.0, -1.1, -0.4, 0.3, 1.1, 3.0])
def test_metrics_of_zpetc_and_ts_are_of_the_toeplitz_matrix_of_e(a):
    for name, formula in (("ZPETC", zpetc_metric), ("TS", series_metric)):
        E = error_dynamics(name, a)
        assert metric(non_causal(E.c, E.ahead, 1000)) == pytest.approx(formula(a), rel=1e-9)


def test_composed_lifted_matrices_have_edges_that_the_formula_has_not():
    """I - G C of lifted G and C differs from the Toeplitz matrix of E by up to half a percent."""
    a, last = -1.1, 200
    G, C = non_causal(np.array([1.0, -a]), 0, last), non_causal(np.array([-a, 1.0]) / (1 - a) ** 2, 1, last)
    composed = metric(np.eye(last + 1) - G @ C)
    E = error_dynamics("ZPETC", a)
    apart = abs(composed / metric(non_causal(E.c, E.ahead, last)) - 1)
    assert 1e-5 < apart < 5e-3


def test_methods_say_where_they_do_not_apply():
    assert error_dynamics("ZPETC", 1.0) is None and error_dynamics("ZPETC", -1.0) is not None
    assert error_dynamics("TS", 1.0) is None and error_dynamics("TS", -1.0) is None


def test_zeros_meet_minus_one_zero_and_one_exactly():
    a = zeros(0.02)
    assert len(a) == 501 and {-5.0, -1.0, 0.0, 1.0, 1.02, 5.0} <= set(a.tolist())


def test_the_printed_printer_model_is_stable_with_unit_gain():
    assert np.abs(np.roots(TAZ6_A)).max() < 1
    assert TAZ6_B.sum() / TAZ6_A.sum() == pytest.approx(1, abs=1e-5)
    assert sorted(np.roots(TAZ6_B[1:]), key=abs)[-1].real == pytest.approx(0.9924, abs=2e-4)


def test_the_stage_has_what_app_h_tells_of():
    b, a = stage()
    assert b[0] == pytest.approx(0, abs=1e-12) and abs(b[1]) > 1e-9  # relative degree one
    assert np.abs(np.roots(a)).max() < 1 and b.sum() / a.sum() == pytest.approx(1, abs=1e-3)
    outside = [z for z in np.roots(b[1:]) if abs(z) > 1 and abs(z.imag) < 1e-6 and z.real > 0]
    assert len(outside) == 1


def test_too_few_pulses_of_a_family_still_weigh_one():
    g = realisations()[:2, :50]
    each = family(np.stack([causal(row) for row in g]), np.array([0.5, 0.5]))
    np.testing.assert_allclose(each.mean, causal(g.mean(axis=0)))
