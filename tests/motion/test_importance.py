"""Laws of the weights of a path's samples."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.motion.importance import importance


@given(st.lists(st.booleans(), max_size=60), st.floats(0, 1), st.integers(1, 30))
def test_a_sample_weighs_by_its_distance_from_printing(extruding, travel, ramp):
    """Against the definition, sample by sample."""
    prints = np.flatnonzero(extruding)
    away = [min((abs(i - k) for i in prints), default=ramp) for k in range(len(extruding))]
    expected = [1 - (1 - travel) * min(d / ramp, 1) for d in away]
    np.testing.assert_allclose(importance(np.array(extruding, bool), travel, ramp), expected, atol=1e-12)
