"""Every item of the catalogue is well formed; the quick ones are recomputed, and their numbers hold."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from fbfcli.papers.catalogue import items
from fbfcli.papers.item import DIFFERS, NOT_REPRODUCIBLE

ALL = items()
SEEDS = 20


def test_names_are_distinct_and_can_be_typed():
    names = [item.name for item in ALL]
    assert len(set(names)) == len(names)
    assert all(set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789-.") for name in names)


@pytest.mark.parametrize("item", [item for item in ALL if item.quick], ids=lambda item: item.name)
def test_a_quick_item_holds(item):
    told = []
    result = item.compute(SEEDS, told.append)
    assert result.rows
    assert not [row for row in result.rows if row.verdict == DIFFERS]
    assert all(row.note for row in result.rows if row.verdict == NOT_REPRODUCIBLE), "a reason is missing"
    assert all(0 <= done <= 1.000001 for done in told)
    if result.figure:
        figure = Figure(layout="constrained")
        result.figure(figure)
        assert figure.axes and "Eq" in result.caption
        for axes in figure.axes:
            assert axes.get_ylabel() or axes.get_images() or axes.get_shared_y_axes().get_siblings(axes) != [axes]
        assert any(axes.get_xlabel() for axes in figure.axes)
