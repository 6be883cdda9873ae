"""Figures of a streamed print are the figures of its samples."""

import json
from itertools import pairwise

import numpy as np
import pytest
from execution_cases import DT, cut, joined, mode, wandering
from hypothesis import given, settings
from hypothesis import strategies as st

from fbfcli.verify.account import Account, Accounted
from fbfcli.verify.log_bins import RATIO, LogBins
from fbfcli.verify.passages import Passages

SEEDS = st.integers(0, 2**32 - 1)
FEATURES = ["unknown", "Perimeter", "External perimeter", "Infill"]


def accounted(pieces) -> tuple[Accounted, list]:
    machine, account = Passages(mode(40.0, 0.1)), Account(FEATURES)
    passages = [p for p in [*(machine.add(piece) for piece in pieces), machine.finish()] if p is not None]
    for passage in passages:
        account.add(passage)
    account.finish()
    return account.figures(), passages


@settings(max_examples=30)
@given(SEEDS, st.lists(st.integers(1, 899), max_size=5))
def test_every_sample_counts_once_wherever_it_is_cut(seed, cuts):
    whole = wandering(seed, 900, [400])
    whole = type(whole)(**{**whole.__dict__, "feature": whole.line % 4})
    pieces = [cut(whole, a, b) for a, b in pairwise(np.unique([0, *cuts, 900]).tolist())]
    told, passages = accounted(pieces)
    one = joined(passages)
    prints = whole.extruding
    assert told.extruding == pytest.approx(DT * prints.sum()) and told.travel == pytest.approx(DT * (~prints).sum())
    for kind in ("tracking", "contour", "along"):
        error = 1e3 * np.abs(getattr(one, kind))
        for figures, group in (
            (told.total, prints), (told.off, ~prints),
            *((told.by_layer[k], prints & (whole.layer == k)) for k in told.by_layer),
            *((told.by_feature[k], prints & (whole.feature == k)) for k in told.by_feature),
        ):  # fmt: skip
            found = getattr(figures, kind)
            if not group.any():
                continue
            assert found.rms == pytest.approx(np.sqrt(np.mean(error[group] ** 2)), rel=1e-9)
            assert found.max == pytest.approx(error[group].max(), rel=1e-9)
            near = np.quantile(error[group], [0.98, 1.0], method="inverted_cdf")
            assert near[0] / RATIO - 0.2 <= found.p99 <= near[1] * RATIO + 0.2
    assert set(told.by_layer) == set(whole.layer[prints].tolist())


@given(SEEDS, st.integers(1, 400), st.integers(1, 5))
def test_percentiles_of_many_groups_are_within_a_bin(seed, n, groups):
    rng = np.random.default_rng(seed)
    group, value = rng.integers(0, groups, n), 10 ** rng.uniform(-4, 1, n)
    bins = LogBins()
    for part in np.array_split(np.arange(n), 3):
        bins.add(group[part], value[part])
    for k in np.unique(group).tolist():
        mine = value[group == k]
        assert bins.count[k] == len(mine) and bins.max[k] == mine.max()
        assert bins.rms[k] == pytest.approx(np.sqrt(np.mean(mine**2)))
        for q in (0.5, 0.99):
            true = np.quantile(mine, q, method="inverted_cdf")
            assert true / RATIO <= bins.quantile(q)[k] <= true * RATIO
    assert bins.all().count.tolist() == [n] and bins.all().max[0] == value.max()


def test_it_can_be_written_as_json():
    told, _ = accounted([wandering(3, 900, [])])
    text = json.dumps(told.as_dict(FEATURES))
    assert {"total", "by_layer", "by_feature", "walls", "worst", "bead"} <= json.loads(text).keys()


def test_of_nothing():
    told = Account(FEATURES).figures()
    assert told.total.contour.max == 0.0 and told.by_layer == {} and told.corners.count == 0 and told.walls == ()
