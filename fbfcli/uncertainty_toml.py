"""What a profile says of how sure a model is, and of where it holds: [axis.x.uncertainty] and [[axis.x.at]]."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from fbfcli.printer import COORDINATES, WIDEST, Family, Model, Place, Spread
from fbfcli.toml_table import Table

MODEL_KEYS = ("modes", "b", "impulse_response", "frequency_response", "a", "dt")  # of every form of a model
FACTORS = "factors on the model's: frequency = [0.85, 1.15]"
EXAMPLE_PLACE = "[{ mass = 0.0, model = { modes = [...] } }, { mass = 0.5, model = { modes = [...] } }]"

ModelOf = Callable[[Table], Model]


def uncertainty(axis: Table, model_of: ModelOf) -> Spread | Family:
    """[axis.x.uncertainty]: ranges, or a family of models. Raises ProfileError."""
    table = axis.table("uncertainty").only("frequency", "damping", "family")
    if "family" in table.values:
        table.only("family")
        if "at" in axis.values:
            table.refuse("family", "cannot go with models at places", "give ranges of frequency and damping instead")
        return _family(table, model_of)
    if not table.values.keys() & {"frequency", "damping"}:
        table.refuse("frequency", "is missing", f"{FACTORS}, damping = [0.5, 2.0], or family = [...]")
    if "model" not in axis.values and "at" not in axis.values:
        axis.refuse("uncertainty", "is there without a model", f"add a section [{axis.where('model')}]")
    return Spread(_factors(table, "frequency"), _factors(table, "damping"))


def places(axis: Table, model_of: ModelOf) -> tuple[Place, ...]:
    """[[axis.x.at]]: models and where they were measured. Raises ProfileError."""
    tables = axis.tables("at", EXAMPLE_PLACE)
    found: dict[tuple[float, ...], Place] = {}
    for table in tables:
        table.only(*COORDINATES, "model")
        told = tuple(name for name in COORDINATES if name in table.values)
        if not told:
            axis.refuse("at", "a model without a place", f"say where it holds: any of {', '.join(COORDINATES)}")
        if any((name in table.values) != (name in tables[0].values) for name in COORDINATES):
            axis.refuse("at", f"places differ in what they tell: {', '.join(told)} and others", "tell the same of each")
        where = tuple(table.number(name, above=-inf, least=0.0 if name == "mass" else -inf) for name in told)
        if where in found:
            axis.refuse("at", f"two models at {', '.join(f'{n} = {v:g}' for n, v in zip(told, where, strict=True))}")
        found[where] = Place(model_of(table.table("model")), **dict(zip(told, where, strict=True)))
    return tuple(found.values())


def _family(table: Table, model_of: ModelOf) -> Family:
    members = table.tables("family", "family = [{ modes = [...] }, { modes = [...], weight = 2.0 }]")
    for member in members:
        member.only("weight", *MODEL_KEYS)
    weights = [member.number("weight", 1.0) for member in members]
    models = tuple(
        model_of(Table(member.file, member.path, {k: v for k, v in member.values.items() if k != "weight"}))
        for member in members
    )
    total = sum(weights)
    return Family(models, tuple(weight / total for weight in weights))


def _factors(table: Table, key: str) -> tuple[float, float]:
    """Lowest and highest factor; 1 where the key is missing."""
    if key not in table.values:
        return 1.0, 1.0
    values = table.numbers(key, FACTORS)
    if len(values) != 2 or not 1.0 / WIDEST <= values[0] <= values[1] <= WIDEST:
        table.refuse(key, f"must be two factors, the lower first, from {1 / WIDEST:g} to {WIDEST:g}", FACTORS)
    return values[0], values[1]
