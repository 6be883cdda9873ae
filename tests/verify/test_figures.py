"""The picture of the worst corner is one, and draws errors where they are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trace_cases import square

from fbfcli.verify.figures import before_after, magnified, png, worst_seen
from fbfcli.verify.traces import Kept, Traces


def kept(amplitude: float) -> Kept:
    traces = Traces(10_000, 4)
    traces.add("as sliced", square(3, amplitude, 1))
    traces.add("lpfbs", square(3, 0.1 * amplitude, 2))
    return traces.kept()


@settings(max_examples=10)
@given(st.floats(1.0, 100.0))
def test_errors_drawn_larger_are_as_many_times_as_far_from_the_path(times):
    window = kept(0.3).corners[0].windows["as sliced"]
    straight = window[: len(window) // 3]  # of one side
    off = magnified(straight, times) - straight.nozzle
    np.testing.assert_allclose(np.hypot(*off.T), (times - 1) * np.abs(straight.error), atol=1e-9)
    np.testing.assert_array_equal(magnified(window, 1.0), window.nozzle)


@pytest.mark.parametrize("amplitude", (1.0, 0.2, 0.004))
def test_the_picture_shows_both_methods_and_says_how_much_larger_errors_are(amplitude):
    found = kept(amplitude)
    figure = before_after(found, found.corners[0], "a corner")
    plan, errors = figure.axes
    assert [line.get_label() for line in plan.lines[:3]] == ["desired path", "nozzle, as sliced", "nozzle, lpfbs"]
    assert len(errors.lines) == 2 and ("larger" in plan.get_title()) == (amplitude < 0.1)
    assert png(figure).startswith(b"\x89PNG")


def test_outer_walls_come_first():
    found = kept(0.3)
    assert worst_seen(found, ("infill", "infill")) is found.corners[0]
    for names in (("infill", "Outer wall"), ("External perimeter", "infill")):
        shown = worst_seen(found, names)
        outer = names.index(next(name for name in names if name != "infill"))
        assert shown.feature == outer and shown.method == "as sliced"
        assert shown.error == max(c.error for c in found.corners if c.feature == outer and c.method == "as sliced")
    assert worst_seen(Traces().kept(), ()) is None
