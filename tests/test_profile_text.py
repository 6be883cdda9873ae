"""A measured model goes into a profile; what people wrote around it stays."""

from __future__ import annotations

import pytest

from fbfcli.errors import ProfileError
from fbfcli.printer import Family, ImpulseResponse, ModalModel, Mode, Place, Spread, TransferFunction
from fbfcli.printer_toml import parse_printer
from fbfcli.profile_text import new_profile, with_model, with_model_at

MODES = ModalModel((Mode(41.5, 0.06, 0.7), Mode(80.0, 0.04, 0.3)))
FILTER = TransferFunction((0.0, 0.5, 0.5), (1.0,), 0.001)
SPREAD = Spread((0.97, 1.03), (0.8, 1.25))


@pytest.mark.parametrize("model", [MODES, FILTER])
@pytest.mark.parametrize("spread", [SPREAD, Family((MODES, FILTER), (0.25, 0.75)), None])
def test_what_is_written_is_read_again(model, spread):
    text = with_model(new_profile("mine", "measured"), "p.toml", "y", model, spread, "of a test")
    printer = parse_printer(text, "p.toml")
    assert printer.axes[1].model == model
    assert printer.axes[0].model is None


def test_comments_and_everything_else_stay(root):
    old = (root / "configs" / "synthetic_two_mode.toml").read_text()
    marked = old.replace("[axis.x.model]", "# my own words\n[axis.x.model] # and these")
    new = with_model(marked, "p.toml", "x", MODES, SPREAD, "again")
    kept = [line for line in marked.splitlines() if not line.startswith("modes")]
    assert [line for line in kept if line not in new.splitlines()] == []
    assert parse_printer(new, "p.toml").axes[1].model == parse_printer(old, "p.toml").axes[1].model


def test_updating_twice_is_updating_once():
    once = with_model(new_profile("mine", "measured"), "p.toml", "x", MODES, SPREAD, "a")
    assert with_model(once, "p.toml", "x", MODES, SPREAD, "a") == once


def test_another_form_takes_the_place_of_the_old_one():
    text = with_model(new_profile("mine", "measured"), "p.toml", "x", MODES, SPREAD, "a")
    text = with_model(text, "p.toml", "x", FILTER, None, "b")
    assert parse_printer(text, "p.toml").axes[0].model == FILTER
    assert "modes" not in text and "uncertainty" not in text


def test_ranges_are_rounded_outwards():
    text = with_model(new_profile("mine", "x"), "p.toml", "x", MODES, Spread((0.98765, 1.01234), (0.9, 1.1)), "a")
    assert "frequency = [0.987, 1.013]" in text


def test_names_that_toml_cannot_hold_are_made_so():
    assert parse_printer(with_model(new_profile('a"b\\\n', ""), "p", "x", MODES, None, 'q"'), "p").name == "ab"


@pytest.mark.parametrize(
    "text, why", [("[printer", "not TOML"), ("[printer]\n", "axis.x is missing"), ("axis = 3", "missing")]
)
def test_what_is_no_profile_is_refused(text, why):
    with pytest.raises(ProfileError, match=why):
        with_model(text, "p.toml", "x", MODES, None, "a")


def test_a_form_that_has_no_place_in_a_profile_is_refused():
    with pytest.raises(ProfileError, match="only modes"):
        with_model(new_profile("a", "b"), "p", "x", ImpulseResponse((1.0,), 0.001), None, "a")


SOFT = ModalModel((Mode(32.0, 0.06),))


def at_places(text, *places, spread=SPREAD):
    for place in places:
        text = with_model_at(text, "p.toml", "y", place, spread, "of a test")
    return text


@pytest.mark.parametrize("model", [MODES, FILTER])
def test_models_at_places_are_read_again(model):
    places = Place(model, x=0.0, y=20.0), Place(SOFT, x=200.0, y=20.0)
    axis = parse_printer(at_places(new_profile("mine", "measured"), *places), "p.toml").axes[1]
    assert axis.at == places
    assert axis.uncertainty == SPREAD


def test_a_place_that_is_there_gets_the_new_model():
    text = at_places(new_profile("mine", "x"), Place(MODES, mass=0.0), Place(MODES, mass=0.5), Place(SOFT, mass=0.5))
    assert parse_printer(text, "p.toml").axes[1].at == (Place(MODES, mass=0.0), Place(SOFT, mass=0.5))
    assert at_places(text, Place(SOFT, mass=0.5)) == text


OF_HAND = """# how the bed moves
[[axis.y.at]] # empty
mass = 0.0 # kg
model = { modes = [{ frequency = 40.0, damping = 0.05 }] } # in May

[[axis.y.at]]
mass = 0.5
[axis.y.at.model] # in June
modes = [{ frequency = 33.0, damping = 0.05 }]
"""


def test_words_about_places_stay():
    text = new_profile("mine", "x").replace("[axis.z]", OF_HAND + "\n[axis.z]")
    new = at_places(text, Place(SOFT, mass=0.5), Place(MODES, mass=1.0))
    assert [model.modes[0].frequency for model in (p.model for p in parse_printer(new, "p.toml").axes[1].at)] == [
        40.0, 32.0, 41.5]  # fmt: skip
    for words in ("# how the bed moves", "# empty", "# kg", "# in May", "# in June"):
        assert words in new
    kept = [line for line in text.splitlines() if "33.0" not in line]
    assert [line for line in kept if line not in new.splitlines()] == []


def test_places_in_one_line_are_kept_there():
    line = "at = [{ mass = 0.0, model = { modes = [{ frequency = 40.0, damping = 0.05 }] } }] # mine"
    text = new_profile("mine", "x").replace("[axis.z]", f"{line}\n\n[axis.z]")
    new = at_places(text, Place(SOFT, mass=0.5), Place(MODES, mass=0.0))
    assert parse_printer(new, "p.toml").axes[1].at == (Place(MODES, mass=0.0), Place(SOFT, mass=0.5))
    assert "# mine" in new


def test_ranges_of_several_places_hold_each_and_a_family_makes_room():
    family = with_model(new_profile("mine", "x"), "p.toml", "y", MODES, Family((MODES, SOFT), (0.5, 0.5)), "a")
    text = at_places(family, Place(MODES, z=0.0), spread=Spread((0.98, 1.02), (0.9, 1.2)))
    text = at_places(text, Place(MODES, z=9.0), spread=Spread((0.99, 1.05), (0.8, 1.1)))
    assert parse_printer(text, "p.toml").axes[1].uncertainty == Spread((0.98, 1.05), (0.8, 1.2))


def test_places_told_otherwise_are_refused():
    text = at_places(new_profile("mine", "x"), Place(MODES, z=0.0))
    with pytest.raises(ProfileError, match="tell z, this one x, y"):
        at_places(text, Place(MODES, x=0.0, y=1.0))
