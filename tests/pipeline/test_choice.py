"""The rule that picks a method, and what it says."""

from __future__ import annotations

from dataclasses import replace

import pytest
from print_cases import printer

from fbfcli.pipeline import Settings
from fbfcli.pipeline.choice import chosen, uncertainty_of
from fbfcli.plant.uncertainty import ASSUMED, ASSUMED_AT
from fbfcli.printer import Family, ModalModel, Mode, Place, Printer, Spread

ONE, TWO = ModalModel((Mode(40.0, 0.06),)), ModalModel((Mode(40.0, 0.06, 0.7), Mode(70.0, 0.05, 0.3)))


def machine(x: Spread | Family | None = None, y: Spread | Family | None = None, model: ModalModel = ONE) -> Printer:
    """A printer whose profile says this of how exact its axes' models are."""
    base = printer("klipper", model)
    axes = (replace(base.axes[0], uncertainty=x), replace(base.axes[1], uncertainty=y), base.axes[2])
    return replace(base, axes=axes)


def within(part: float) -> Spread:
    return Spread((1 - part, 1 + part))


@pytest.mark.parametrize(("profile", "spread", "method"), [
    (machine(), None, "contour"),
    (machine(), 0.15, "contour"),
    (machine(), 0.05, "contour"),
    (machine(), 0.03, "lpfbs"),
    (machine(), 0.0, "lpfbs"),
    (machine(model=TWO), 0.03, "contour"),
    (machine(model=TWO), 0.02, "lpfbs"),
    (machine(Spread(), Spread()), None, "lpfbs"),
    (machine(Spread(), Spread()), 0.1, "contour"),
    (machine(Spread(), None), None, "contour"),
    (machine(within(0.02), within(0.1)), None, "contour"),
    (machine(Spread(damping=(0.5, 2.0)), Spread()), None, "lpfbs"),
    (machine(Family((ONE, TWO), (0.5, 0.5)), Spread()), None, "contour"),
    (machine(Family((ONE,), (1.0,)), Spread()), None, "lpfbs"),
])  # fmt: skip
def test_exact_models_are_inverted_and_others_are_borne(profile, spread, method):
    assert chosen(profile, Settings(spread=spread)).method == method


def test_what_is_asked_for_is_taken():
    for method in ("none", "mzv", "lpfbs", "robust", "contour"):
        assert chosen(machine(), Settings(method=method)).method == method


def test_it_says_who_said_how_exact_the_models_are():
    assert "does not say" in chosen(machine(), Settings()).why
    assert "-15 to +15 %" in chosen(machine(), Settings()).why
    assert "as asked for" in chosen(machine(), Settings(spread=0.1)).why
    assert "says the profile" in chosen(machine(within(0.1), within(0.1)), Settings()).why
    assert "one mode" in chosen(machine(), Settings(spread=0.0)).why
    assert chosen(machine(), Settings(method="mzv")).why == ""


def test_models_at_places_are_taken_to_be_nearer():
    axis = machine().axes[0]
    assert uncertainty_of(axis, Settings()) == ASSUMED
    assert uncertainty_of(replace(axis, at=(Place(ONE, z=0.0),)), Settings()) == ASSUMED_AT
    assert uncertainty_of(replace(axis, uncertainty=within(0.2)), Settings()) == within(0.2)


def test_it_says_which_models_change_along_the_print():
    base = machine()
    axes = (base.axes[0], replace(base.axes[1], at=(Place(ONE, z=0.0, mass=0.1),)), base.axes[2])
    for method in ("auto", "mzv"):
        why = chosen(replace(base, axes=axes), Settings(method=method)).why
        assert "model of y changes with z and mass" in why
