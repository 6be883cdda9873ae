"""A zero that moves: every method is as good as its metric says, or says that it does not apply."""

from __future__ import annotations

import numpy as np
import pytest

from fbfcli.control.lifted import causal, markov, metric, non_causal
from fbfcli.papers.ramani_2018 import ABSENT, METHODS, MOST_SD, fbf_sweep, lti_sweep, plant
from fbfcli.papers.zero_sweep import POLE, M, noise

A = np.array([-5.0, -2.0, -1.02, -1.0, -0.98, -0.5, 0.0, 0.1, 0.5, 0.98, 1.0, 1.02, 2.0, 5.0])
Y_D = noise(20)


@pytest.mark.parametrize("name", METHODS)
def test_an_lti_method_errs_as_its_metric_says_or_does_not_apply(name):
    sweep = lti_sweep(name, A, Y_D)
    assert sweep.farthest < MOST_SD
    absent = sweep.a[np.isnan(sweep.error)].tolist()
    assert absent == {"a = 1": [1], "|a| = 1": [-1, 1]}.get(ABSENT[name], [0.5, 0.98, 1, 1.02, 2, 5])


def test_fbf_errs_the_same_wherever_the_zero_is():
    sweep = fbf_sweep("block pulses", np.array([-1.0, 1.0, 2.0]), Y_D, lambda: None)
    assert sweep.farthest < MOST_SD
    assert sweep.error.max() < 1.3 * sweep.error.min()


def test_a_wrong_metric_is_noticed():
    """The tolerance is small enough to tell ZPETC's metric from one 10 % off."""
    sweep = lti_sweep("ZPETC", np.array([-2.0]), Y_D)
    assert abs((1.1 * sweep.error[0] / sweep.J_e[0]) ** 2 - 1) / sweep.sd[0] > MOST_SD


@pytest.mark.parametrize("a", [-1.5, 2.0])
def test_the_metric_is_of_the_toeplitz_matrix_of_e_and_not_of_composed_matrices(a):
    """I - G C of lifted G and C misses what the ends cut off: up to half a percent of ZPETC's J_e."""
    from fbfcli.control.inversion import zpetc

    made = zpetc(plant(a))
    E = made.L.error()
    of_E = metric(non_causal(E.c, E.ahead, M))
    assert of_E == pytest.approx(np.sqrt(6 - 2 / (M + 1)) * abs(a) / (1 - a) ** 2, rel=1e-9)
    C = non_causal(made.C.c, made.C.ahead, M)
    composed = metric(np.eye(M + 1) - causal(markov(np.array([1, -a]), np.array([1, -POLE]), M)) @ C)
    assert 1e-5 < abs(composed / of_E - 1) < 5e-3
