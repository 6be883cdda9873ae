"""Travel: the first move that leaves it is named, and nothing else is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_moves import paths

from fbfcli.errors import GcodeError
from fbfcli.motion.travel import check_travel


@given(paths(), st.floats(0, 30), st.data())
def test_the_first_known_move_outside_is_named(moves, reach, data):
    known = np.array(data.draw(st.lists(st.booleans(), min_size=len(moves), max_size=len(moves))))
    travel = ((-reach, reach), (-reach - 5.0, reach + 5.0))
    end = moves.start[:, :2] + moves.delta[:, :2]
    outside = known & ((np.abs(end) > np.array([reach, reach + 5.0]) + 1e-6).any(axis=1))
    if not outside.any():
        check_travel(moves, known, travel)
        return
    with pytest.raises(GcodeError, match="outside the printer's travel") as refused:
        check_travel(moves, known, travel)
    assert outside[list(moves.line).index(refused.value.line - 1)]
    assert refused.value.remedy


@given(paths())
def test_the_travel_itself_may_be_used(moves):
    end = moves.start[:, :2] + moves.delta[:, :2]
    travel = tuple((float(end[:, i].min()), float(end[:, i].max())) for i in (0, 1))
    check_travel(moves, np.ones(len(moves), bool), travel)
