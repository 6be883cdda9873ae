"""Laws of the simulated nozzle."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from fbfcli.plant.model import impulse_response, plant_of
from fbfcli.printer import ModalModel, Mode
from fbfcli.verify.simulate import REST_SAMPLES, Nozzle

DT = 1e-3
PLANTS = [plant_of(ModalModel((Mode(f, 0.1),)), DT, "x") for f in (40.0, 55.0)]
B_A = [(plant.b, plant.a) for plant in PLANTS]
RIGID = [(np.ones(1), np.ones(1))] * 2
SEEDS = st.integers(0, 2**32 - 1)


def stretches(seed: int, sizes: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random walks from where the one before ended, their first samples, and rests before them."""
    rng = np.random.default_rng(seed)
    n = sum(sizes)
    begin = np.cumsum([0, *sizes[:-1]])
    step = rng.normal(0, 0.1, (n, 2))
    step[begin] = 0.0
    return 50.0 + np.cumsum(step, axis=0), begin, rng.integers(0, 40, len(sizes))


sizes = st.lists(st.integers(2, 60), min_size=1, max_size=6)


@given(SEEDS, sizes)
def test_the_nozzle_is_the_filtered_command_rests_included(seed, sizes):
    u, begin, rest = stretches(seed, sizes)
    pieces, keep = [], []
    for a, b, r in zip(begin, [*begin[1:], len(u)], rest, strict=True):
        before = u[a - 1] if a else u[0]
        pieces += [np.repeat(before[None], r, 0), u[a:b]]
        keep += [np.zeros(r, bool), np.ones(b - a, bool)]
    whole, here = np.concatenate(pieces), np.concatenate(keep)
    y = Nozzle(B_A).follow(u, begin, rest)
    for axis, (b, a) in enumerate(B_A):
        expected = u[0, axis] + lfilter(b, a, whole[:, axis] - u[0, axis])[here]
        np.testing.assert_allclose(y[:, axis], expected, atol=1e-9)


@given(SEEDS, sizes, st.integers(0, 6))
def test_a_nozzle_fed_in_pieces_goes_the_same_way(seed, sizes, cut):
    u, begin, rest = stretches(seed, sizes)
    whole = Nozzle(B_A).follow(u, begin, rest)
    k = min(cut, len(begin) - 1)
    if k == 0:
        return
    nozzle = Nozzle(B_A)
    first = nozzle.follow(u[: begin[k]], begin[:k], rest[:k])
    second = nozzle.follow(u[begin[k] :], begin[k:] - begin[k], rest[k:])
    np.testing.assert_allclose(np.concatenate([first, second]), whole, atol=1e-9)


@given(SEEDS, st.integers(2, 100), st.integers(1, 99))
def test_a_stretch_cut_in_its_middle_goes_the_same_way(seed, size, cut):
    u, begin, rest = stretches(seed, [size])
    cut = min(cut, size - 1)
    none = np.zeros(0, dtype=np.int64)
    nozzle = Nozzle(B_A)
    pieces = [nozzle.follow(u[:cut], begin, rest), nozzle.follow(u[cut:], none, none)]
    np.testing.assert_allclose(np.concatenate(pieces), Nozzle(B_A).follow(u, begin, rest), atol=1e-9)


def test_a_command_at_rest_leaves_the_nozzle_there():
    u = np.tile([12.0, -7.0], (300, 1))
    np.testing.assert_allclose(Nozzle(B_A).follow(u, np.array([0]), np.array([0])), u, atol=1e-12)


def test_after_a_step_the_nozzle_overshoots_as_its_damping_says_and_arrives():
    """exp(-pi zeta / sqrt(1 - zeta^2))."""
    u = np.ones((1500, 2))
    u[0] = 0.0
    y = Nozzle(B_A).follow(u, np.array([0]), np.array([0]))
    overshoot = exp(-pi * 0.1 / sqrt(1 - 0.01))
    np.testing.assert_allclose(y.max(axis=0) - 1.0, overshoot, rtol=0.02)
    np.testing.assert_allclose(y[-1], 1.0, atol=1e-6)


@given(SEEDS, sizes)
def test_a_rigid_nozzle_is_the_command(seed, sizes):
    u, begin, rest = stretches(seed, sizes)
    np.testing.assert_allclose(Nozzle(RIGID).follow(u, begin, rest), u, atol=1e-12)


@given(SEEDS, st.floats(-80, 80))
def test_a_displacement_between_stretches_moves_the_whole_plant(seed, jump):
    """A move that is passed through uncompensated leaves no vibration of its own here."""
    u, begin, rest = stretches(seed, [50, 50])
    moved = u.copy()
    moved[50:] += jump
    a, b = (Nozzle(B_A).follow(command, begin, rest) for command in (u, moved))
    np.testing.assert_allclose(b[:50], a[:50], atol=1e-9)
    np.testing.assert_allclose(b[50:], a[50:] + jump, atol=1e-9)


@pytest.mark.parametrize("longer", (1, 1000, 10**9))
def test_long_rests_are_all_alike(longer):
    u, begin, _ = stretches(3, [80, 80])
    rests = [np.array([0, REST_SAMPLES + more]) for more in (0, longer)]
    a, b = (Nozzle(B_A).follow(u, begin, rest) for rest in rests)
    np.testing.assert_array_equal(a, b)


@given(SEEDS, sizes, st.integers(0, 6))
def test_a_long_finite_response_is_the_filter_it_stands_for(seed, sizes, cut):
    """Transforms against the recursion they replace, in one piece and in two."""
    u, begin, rest = stretches(seed, sizes)
    h = [np.append(impulse_response(plant), np.zeros(3)) for plant in PLANTS]
    expected = Nozzle([(h_i, np.array([1.0, 0.0])) for h_i in h]).follow(u, begin, rest)  # len(a) 2: lfilter
    nozzle = Nozzle([(h_i, np.ones(1)) for h_i in h])
    k = min(cut, len(begin) - 1)
    pieces = [nozzle.follow(u[: begin[k]], begin[:k], rest[:k])] if k else []
    pieces.append(nozzle.follow(u[begin[k] :], begin[k:] - begin[k], rest[k:]))
    np.testing.assert_allclose(np.concatenate(pieces), expected, atol=1e-9)


@given(SEEDS, sizes, st.integers(0, 6))
def test_places_of_one_plant_are_one_plant(seed, sizes, cut):
    """Told of places or not, in one piece and in two."""
    u, begin, rest = stretches(seed, sizes)
    place = np.sort(np.random.default_rng(seed).integers(0, 4, len(u)))
    expected = Nozzle(B_A).follow(u, begin, rest)
    k = min(cut, len(begin) - 1)
    nozzle = Nozzle(lambda place: B_A)
    first = [nozzle.follow(u[: begin[k]], begin[:k], rest[:k], place[: begin[k]])] if k else []
    last = nozzle.follow(u[begin[k] :], begin[k:] - begin[k], rest[k:], place[begin[k] :])
    np.testing.assert_allclose(np.concatenate([*first, last]), expected, atol=1e-9)


@given(SEEDS)
def test_at_each_place_the_nozzle_moves_as_the_plant_that_holds_there(seed):
    """Plants change after 300 samples, and back: each piece is what its plant makes of all of the command."""
    rng = np.random.default_rng(seed)
    u = 50.0 + np.cumsum(rng.normal(0, 0.1, (900, 2)), axis=0)
    other = [(b, a) for b, a in reversed(B_A)]
    place = np.repeat([0, 1, 0], 300)
    y = Nozzle(lambda place: other if place else B_A).follow(u, np.array([0]), np.array([0]), place)
    whole = [Nozzle(each).follow(u, np.array([0]), np.array([0])) for each in (B_A, other)]
    np.testing.assert_allclose(y, np.where((place == 1)[:, None], whole[1], whole[0]), atol=1e-9)
