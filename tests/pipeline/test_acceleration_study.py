"""Print time and contour error by acceleration: what compensation is for, on a part of a few moves."""

from __future__ import annotations

import pytest
from print_cases import printer

from fbfcli.errors import GcodeError
from fbfcli.papers.item import NOT_REPRODUCIBLE
from fbfcli.pipeline import acceleration_study
from fbfcli.pipeline.acceleration_study import ACCELERATIONS, item, study

SQUARES = b"G28\nM83\nG1 X40 Y40 F9000\n" + b"".join(
    b"G1 X%d Y40 E1\nG1 X%d Y80 E1\nG1 X40 Y80 E1\nG1 X40 Y40 E1\nG4 P200\n" % (80 + k, 80 + k) for k in range(4)
)


def test_faster_prints_shake_more_and_compensated_ones_hardly():
    told = []
    found = study(SQUARES, printer(), told.append)
    assert list(found) == list(ACCELERATIONS) and told[-1] == 1
    times = [plain.time for plain, _ in found.values()]
    assert times == sorted(times, reverse=True)
    assert all(compensated.after < plain.after for plain, compensated in found.values())
    assert all(compensated.after < plain.after / 2 for a, (plain, compensated) in found.items() if a >= 5)


@pytest.mark.parametrize("part", [b"G28\n", b"G28\nG4 P100\n"])
def test_a_part_without_motion_is_refused(part):
    with pytest.raises(GcodeError, match="sliced print"):
        study(part, printer(), lambda done: None)


def test_the_table_rests_on_what_is_read_when_it_is_computed(monkeypatch):
    monkeypatch.setattr(acceleration_study, "ACCELERATIONS", (1, 10))
    read = []
    table = item(lambda: read.append("part") or SQUARES, lambda: read.append("printer") or printer())
    assert not read
    result = table.compute(1, lambda done: None)
    assert read == ["part", "printer"]
    printed = [row for row in result.rows if row.verdict == NOT_REPRODUCIBLE]
    assert len(printed) == 4 and all(row.note for row in printed)
    assert "Eq. 7" in result.caption
