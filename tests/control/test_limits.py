"""Commands against their limits, stretch by stretch: what array code finds is what each stretch shows alone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.control.limits import CLIPPED, Box, clip, outside, peaks

DT = 1e-3
sizes = st.lists(st.integers(3, 40), min_size=1, max_size=6)
SEEDS = st.integers(0, 2**32 - 1)


def stretches(seed: int, sizes: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Random walks one after the other, and where each begins."""
    rng = np.random.default_rng(seed)
    walks = [rng.uniform(-50, 50, 2) + np.cumsum(rng.normal(0, rng.choice((1e-3, 0.1)), (n, 2)), axis=0) for n in sizes]
    return np.concatenate(walks), np.cumsum([0, *sizes[:-1]])


def each(u: np.ndarray, begin: np.ndarray) -> list[np.ndarray]:
    return np.split(u, begin[1:])


@given(SEEDS, sizes)
def test_peaks_are_those_of_each_stretch_alone(seed, sizes):
    u, begin = stretches(seed, sizes)
    velocity, acceleration = peaks(u, begin, DT)
    for j, one in enumerate(each(u, begin)):
        np.testing.assert_allclose(velocity[j], np.abs(np.diff(one, axis=0)).max(axis=0) / DT, rtol=1e-12)
        np.testing.assert_allclose(acceleration[j], np.abs(np.diff(one, 2, axis=0)).max(axis=0) / DT**2, rtol=1e-9)


@given(SEEDS, sizes, st.floats(0.1, 2.0), st.sampled_from(("low", "high", "velocity", "acceleration")))
def test_a_stretch_is_outside_where_one_sample_is(seed, sizes, share, name):
    u, begin = stretches(seed, sizes)
    wide = {"low": -1e9, "high": 1e9, "velocity": 1e9, "acceleration": 1e12}
    velocity, acceleration = peaks(u, begin, DT)
    most = {"low": u.min(), "high": u.max(), "velocity": velocity.max(), "acceleration": acceleration.max()}
    wide[name] = share * most[name]
    box = Box(**{key: np.full(2, value) for key, value in wide.items()})
    still = np.concatenate([np.repeat(one.mean(axis=0, keepdims=True).clip(wide["low"], wide["high"]), len(one), 0)
                            for one in each(u, begin)])  # fmt: skip
    expected = []
    for one in each(u, begin):
        v, a = np.abs(np.diff(one, axis=0)) / DT, np.abs(np.diff(one, 2, axis=0)) / DT**2
        beyond = (one < wide["low"] - CLIPPED).any() or (one > wide["high"] + CLIPPED).any()
        expected.append(beyond or (v > wide["velocity"]).any()
                        or (a > wide["acceleration"]).any())  # fmt: skip
    np.testing.assert_array_equal(outside(u, still, begin, DT, box), expected)


@given(SEEDS, sizes)
def test_a_command_no_faster_than_the_desired_motion_is_never_outside(seed, sizes):
    u, begin = stretches(seed, sizes)
    tight = Box(np.full(2, -1e9), np.full(2, 1e9), np.full(2, 1e-9), np.full(2, 1e-9))
    assert not outside(u, u, begin, DT, tight).any()


def test_a_jump_between_stretches_is_no_motion():
    u = np.array([[0.0, 0], [0, 0], [0, 0], [99, 99], [99, 99], [99, 99]])
    velocity, acceleration = peaks(u, np.array([0, 3]), DT)
    assert not velocity.any() and not acceleration.any()


@given(SEEDS, sizes, st.floats(-60, 0), st.floats(0, 60))
def test_a_clipped_command_stays_on_the_machine_and_is_itself_there(seed, sizes, low, high):
    u, begin = stretches(seed, sizes)
    box = Box(np.full(2, low), np.full(2, high), np.full(2, 1e9), np.full(2, 1e12))
    clipped = clip(u, box)
    assert clipped.min() >= low and clipped.max() <= high
    within = (u >= low) & (u <= high)
    np.testing.assert_array_equal(clipped[within], u[within])
    assert not outside(clipped, u, begin, DT, box).any()
