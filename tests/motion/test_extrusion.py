"""Klipper aborts a print at a segment that pushes too much: it must not be written."""

import numpy as np
import pytest

from fbfcli.errors import LimitError
from fbfcli.motion.extrusion import check_extrusion
from fbfcli.motion.moves import Moves
from fbfcli.printer import Limits

AREA = np.pi * 1.75**2 / 4
SECTION = 4 * 0.4**2  # Klipper's default for a 0.4 mm nozzle


def segment(length: float, push: float) -> Moves:
    one = np.ones(1)
    delta = np.array([[length, 0, 0, push]])
    return Moves(np.zeros((1, 4)), delta, one, one > 0, one.astype(int), one.astype(int), (Limits(),))


@pytest.mark.parametrize("length, push", [(10.0, 2.0), (0.001, 0.1), (1.0, 0.99 * SECTION / AREA), (10.0, -5.0)])
def test_thin_lines_and_tiny_amounts_pass(length, push):
    check_extrusion(segment(length, push), 0.4, 1.75, SECTION)


@pytest.mark.parametrize("length, push", [(0.1, 0.2), (1.0, 1.01 * SECTION / AREA)])
def test_a_thick_line_is_refused_with_its_place(length, push):
    with pytest.raises(LimitError, match=r"X0.000 Y0.000 .* Klipper"):
        check_extrusion(segment(length, push), 0.4, 1.75, SECTION)
