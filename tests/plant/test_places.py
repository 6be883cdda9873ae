"""Laws of the model between places."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.plant.model import impulse_response, plant_of
from fbfcli.plant.places import between, shares
from fbfcli.printer import ImpulseResponse, ModalModel, Mode, Place

DT = 1e-3
EMPTY, FULL = ModalModel((Mode(40.0, 0.05),)), ModalModel((Mode(32.0, 0.06),))
seeds = st.integers(0, 2**32 - 1)


def along_mass(*masses: float) -> list[Place]:
    return [Place(EMPTY, mass=mass) for mass in masses]


def at_mass(*masses: float) -> np.ndarray:
    return np.array([[0.0, 0.0, 0.0, mass] for mass in masses])


@given(seeds, st.integers(1, 5), st.sets(st.sampled_from("xyz"), min_size=1))
def test_shares_sum_to_one_and_a_place_is_itself(seed, count, told):
    rng = np.random.default_rng(seed)
    where = rng.uniform(-100, 100, (count, 4))
    places = [Place(EMPTY, **{c: row["xyz".index(c)] for c in told}) for row in where]
    share = shares(places, np.vstack([where, rng.uniform(-150, 150, (20, 4))]))
    assert (share >= 0).all()
    np.testing.assert_allclose(share.sum(axis=1), 1.0)
    if count > 1:
        np.testing.assert_allclose(share[:count], np.eye(count), atol=1e-9)


def test_along_one_coordinate_shares_are_linear_and_end_at_the_ends():
    share = shares(along_mass(1.0, 0.0), at_mass(-1.0, 0.0, 0.25, 1.0, 2.0))
    np.testing.assert_allclose(share[:, 0], [0, 0, 0.25, 1, 1])


def test_one_place_is_everywhere():
    np.testing.assert_array_equal(shares(along_mass(0.3), at_mass(0.0, 1.0)), [[1], [1]])


@given(st.floats(0, 1))
def test_a_mass_that_is_added_moves_the_mode_as_a_spring_does(part):
    """k / (m_0 + m) = (2 pi f)^2: what the interpolation must say between two measured masses."""
    model = between((EMPTY, FULL), (1 - part, part), DT, "y")
    ratio = (40 / 32) ** 2 - 1
    assert model.modes[0].frequency == pytest.approx(40 / np.sqrt(1 + ratio * part))
    assert 0.05 <= model.modes[0].damping <= 0.06


def test_modes_meet_their_own_kind_whatever_their_order():
    a = ModalModel((Mode(80.0, 0.05, 0.3), Mode(40.0, 0.05, 0.7)))
    b = ModalModel((Mode(38.0, 0.05, 0.6), Mode(76.0, 0.05, 0.4)))
    modes = between((a, b), (0.5, 0.5), DT, "y").modes
    assert 38 < modes[0].frequency < 40 < 76 < modes[1].frequency < 80
    assert [m.gain for m in modes] == pytest.approx([0.65, 0.35])


def test_other_models_meet_as_responses():
    h = impulse_response(plant_of(FULL, DT, "y"))
    model = between((EMPTY, ImpulseResponse(tuple(h.tolist()), DT)), (0.5, 0.5), DT, "y")
    mixed = impulse_response(plant_of(model, DT, "y"))
    assert mixed.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(mixed[:50], 0.5 * (h[:50] + impulse_response(plant_of(EMPTY, DT, "y"))[:50]))
