"""How sure a model is, and where it holds, as a profile says it: nouns, or one line that says what is wrong."""

from __future__ import annotations

import tomllib

import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.errors import ProfileError
from fbfcli.printer import Family, ModalModel, Mode, Place, Spread
from fbfcli.printer_toml import parse_printer
from tests.test_printer import FULL, values

ONE = {"modes": [{"frequency": 40.0, "damping": 0.05}]}
TWO = {"modes": [{"frequency": 32.0, "damping": 0.06}]}
MODEL_1, MODEL_2 = ModalModel((Mode(40.0, 0.05),)), ModalModel((Mode(32.0, 0.06),))


def read(**keys: object):
    """The X axis of a profile with these keys in [axis.x]; `model` = None takes it away."""
    whole = tomllib.loads(tomlkit.dumps(FULL))
    whole["axis"]["x"] |= keys
    if "model" in keys and keys["model"] is None:
        del whole["axis"]["x"]["model"]
    return parse_printer(tomlkit.dumps(whole), "mine.toml").axes[0]


def refusal(**keys: object) -> str:
    with pytest.raises(ProfileError) as refused:
        read(**keys)
    words = str(refused.value)
    assert "\n" not in words
    assert words.startswith("mine.toml: axis.x")
    return words


def test_a_profile_that_says_nothing_is_not_sure():
    axis = read()
    assert axis.uncertainty is None
    assert axis.at == ()


def test_ranges_are_factors():
    spread = read(uncertainty={"frequency": [0.85, 1.15], "damping": [0.5, 2]}).uncertainty
    assert spread == Spread((0.85, 1.15), (0.5, 2.0))
    assert read(uncertainty={"frequency": [1, 1]}).uncertainty == Spread()


def test_a_family_is_its_models_and_their_probabilities():
    family = read(uncertainty={"family": [ONE, TWO | {"weight": 3}]}).uncertainty
    assert family == Family((MODEL_1, MODEL_2), (0.25, 0.75))


def test_places_keep_what_they_tell_and_the_first_model_is_the_nominal_one():
    axis = read(model=None, at=[{"mass": 0, "model": ONE}, {"mass": 0.5, "model": TWO}])
    assert axis.at == (Place(MODEL_1, mass=0.0), Place(MODEL_2, mass=0.5))
    assert axis.model == MODEL_1
    beside = read(at=[{"x": -5, "z": 1, "model": ONE}, {"x": 5, "z": 1, "model": TWO}])
    assert beside.at[0] == Place(MODEL_1, x=-5.0, z=1.0)
    assert beside.model not in (MODEL_1, MODEL_2)


@pytest.mark.parametrize(("keys", "words"), [
    ({"uncertainty": {}}, "axis.x.uncertainty.frequency: is missing"),
    ({"uncertainty": {"frequenzy": [1, 1]}}, "did you mean frequency?"),
    ({"uncertainty": {"frequency": 0.15}}, "must be a list of numbers"),
    ({"uncertainty": {"frequency": [1.15, 0.85]}}, "two factors, the lower first"),
    ({"uncertainty": {"frequency": [0.85, 1.0, 1.15]}}, "two factors"),
    ({"uncertainty": {"damping": [0.0, 2]}}, "from 0.1 to 10"),
    ({"uncertainty": {"family": []}}, "must be a list of tables"),
    ({"uncertainty": {"family": [{"weight": 1}]}}, "axis.x.uncertainty.family[0].modes: is missing"),
    ({"uncertainty": {"family": [ONE | {"wieght": 2}]}}, "family[0].wieght = 2: unknown key (did you mean weight?)"),
    ({"uncertainty": {"family": [ONE | {"weight": 0}]}}, "family[0].weight = 0: must be greater than 0"),
    ({"uncertainty": {"family": [ONE], "frequency": [1, 1]}}, "unknown key"),
    ({"uncertainty": {"family": [ONE]}, "at": [{"z": 0, "model": ONE}]}, "give ranges"),
    ({"uncertainty": {"frequency": [0.9, 1.1]}, "model": None}, "without a model"),
    ({"at": []}, "must be a list of tables"),
    ({"at": [{"model": ONE}]}, "say where it holds"),
    ({"at": [{"z": 0, "model": ONE}, {"x": 0, "model": ONE}]}, "tell the same of each"),
    ({"at": [{"z": 0, "model": ONE}, {"z": 0, "model": TWO}]}, "two models at z = 0"),
    ({"at": [{"mass": -1, "model": ONE}]}, "must not be less than 0"),
    ({"at": [{"z": 0}]}, "axis.x.at[0].model: is missing"),
    ({"at": [{"hight": 0, "model": ONE}]}, "unknown key"),
])  # fmt: skip
def test_refusals_say_what_to_write(keys, words):
    assert words in refusal(**keys)


KEYS = st.sampled_from(["frequency", "damping", "family", "z", "mass", "model"])
TABLES = st.dictionaries(KEYS, values.filter(lambda value: type(value) is not object))


@given(st.sampled_from(["uncertainty", "at"]), TABLES)
def test_any_value_is_an_axis_or_one_line(key, table):
    try:
        axis = read(**{key: table if key == "uncertainty" else [table]})
    except ProfileError as refused:
        assert "\n" not in str(refused)
        return
    assert axis.uncertainty or axis.at
