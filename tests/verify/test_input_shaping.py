"""A shaper in the firmware is the weighted mean of shifted plans, whatever pieces the plan comes in."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.control.shapers import impulses
from fbfcli.verify.input_shaping import InputShaping, Plan

DT = 1e-3
SHAPERS = [impulses("mzv", 40.0, 0.1), impulses("ei", 30.0, 0.1)]
SET = 7.0  # mm, by which the machine is set without a move


def plan(seed: int, rests: tuple[int, ...]) -> Plan:
    """Pieces of motion between rests of so many periods; before the last of them the machine is set elsewhere."""
    rng = np.random.default_rng(seed)
    ticks, paths, at, tick = [], [], np.zeros(2), 0
    for rest in (*rests, 0):
        n = int(rng.integers(2, 200))
        speed = np.interp(np.arange(n), [0, n / 3, 2 * n / 3, n - 1], [0, 1, 1, 0])[:, None] * rng.uniform(-0.2, 0.2, 2)
        paths.append(at + np.cumsum(speed, axis=0))
        ticks.append(tick + np.arange(n))
        at, tick = paths[-1][-1], tick + n + rest
    moved, was = np.concatenate(paths), np.zeros((sum(map(len, paths)), 2))
    was[-len(paths[-1]) :] = SET
    x = np.column_stack([moved + was, np.zeros((len(moved), 2))])
    return Plan(np.concatenate(ticks), x, was, np.arange(len(moved)))


def shaped(whole: Plan, cuts: list[int]) -> tuple[Plan, np.ndarray]:
    shaping = InputShaping(SHAPERS, DT)
    given = [shaping.push(whole[a:b], last=b == len(whole)) for a, b in pairwise([0, *cuts, len(whole)])]
    first, *others = (samples for samples, _ in given)
    for samples in others:
        first = first.then(samples)
    return first, np.concatenate([u for _, u in given])


def standing(whole: Plan, axis: int, t: np.ndarray) -> np.ndarray:
    """The plan at any time, sets taken out: linear between neighbours, at rest across a gap."""
    moved = whole.x[:, axis] - whole.was[:, axis]
    i = np.clip(np.searchsorted(whole.tick, np.floor(t), side="right") - 1, 0, len(whole) - 1)
    j = np.minimum(i + 1, len(whole) - 1)
    step = np.where(whole.tick[j] - whole.tick[i] == 1, moved[j] - moved[i], 0.0)
    return moved[i] + np.clip(t - whole.tick[i], 0.0, 1.0) * step


seeds, some_rests = st.integers(0, 2**32 - 1), st.lists(st.sampled_from([0, 1, 9, 40, 3000]), max_size=4).map(tuple)


@settings(max_examples=25)
@given(seeds, some_rests)
def test_every_sample_is_the_weighted_mean_of_the_plan(seed, rests):
    whole = plan(seed, rests)
    given_out, u = shaped(whole, [])
    delay = InputShaping(SHAPERS, DT).delay
    t = given_out.tick - delay
    assert (np.diff(given_out.tick) > 0).all() and set(whole.tick.tolist()) <= set(t.tolist())
    for axis, (A, T) in enumerate(SHAPERS):
        offset = (T - A @ T) / DT
        mean = sum(a * standing(whole, axis, t - s) for a, s in zip(A, offset, strict=True))
        assert u[:, axis] - given_out.was[:, axis] == pytest.approx(mean, abs=1e-12)
    assert u[0] == pytest.approx(whole.x[0, :2]) and u[-1] == pytest.approx(whole.x[-1, :2])


@settings(max_examples=25)
@given(seeds, some_rests, st.lists(st.integers(0, 10**6), max_size=6))
def test_pieces_change_nothing(seed, rests, cuts):
    whole = plan(seed, rests)
    one, u = shaped(whole, [])
    many, v = shaped(whole, sorted({1 + cut % (len(whole) - 1) for cut in cuts} if len(whole) > 2 else []))
    assert (one.tick == many.tick).all() and (one.line == many.line).all()
    assert u == pytest.approx(v, abs=1e-12) and one.x == pytest.approx(many.x)
