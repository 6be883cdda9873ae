"""A printer profile as text: what was measured of one axis goes in, everything that people wrote stays as it is."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, floor
from typing import TYPE_CHECKING

from fbfcli.errors import ProfileError
from fbfcli.printer import COORDINATES, Family, ModalModel, Model, Place, Spread, TransferFunction

if TYPE_CHECKING:
    from tomlkit import TOMLDocument
    from tomlkit.items import Table

# What a recording does not tell: to be set by hand. A cartesian Klipper machine with a small bed
SKELETON = """\
[printer]
name = "{name}"
source = "{source}"
firmware = "klipper"      # klipper, marlin, reprapfirmware: please check everything down to the models
kinematics = "cartesian"  # cartesian, corexy, delta

[limits]
velocity = 300
acceleration = 3000

[axis.x]
travel = [0, 235]
steps_per_mm = 80

[axis.y]
travel = [0, 235]
steps_per_mm = 80

[axis.z]
travel = [0, 250]
steps_per_mm = 400
max_velocity = 15
max_acceleration = 200
"""
SHORT = 1e-3  # of a range's width: ends are rounded outwards to it


def new_profile(name: str, source: str) -> str:
    """A profile whose models are still to be put in; its machine is a guess, and says so."""
    return SKELETON.format(name=_one_line(name), source=_one_line(source))


def with_model(text: str, file: str, axis: str, model: Model, spread: Spread | Family | None, note: str) -> str:
    """The profile with another model of one axis, and with what is uncertain of it.

    text   : the profile, TOML
    file   : its name, for messages
    axis   : 'x' or 'y'
    note   : where the model comes from, one line

    Comments, order and spacing of everything else are kept. Raises ProfileError where the text is no profile.
    """
    import tomlkit

    document, section = _parsed(text, file, axis)
    old = section.get("model")
    if isinstance(old, dict):  # changed in place: comments around the section stay where they are
        table = old
    else:
        table = section["model"] = tomlkit.table()
    table["note"] = _one_line(note)
    _replace(table, model)
    if spread is None:
        section.pop("uncertainty", None)
    else:
        section["uncertainty"] = _spread_table(spread)
        if not old:
            section["uncertainty"].add(tomlkit.nl())
    return tomlkit.dumps(document)


def with_model_at(text: str, file: str, axis: str, place: Place, spread: Spread, note: str) -> str:
    """The profile with one axis' model at a place: in [[axis.x.at]], where one at the same place is replaced.

    spread : what is uncertain of it; ranges that are there already are kept where they are wider

    The rest as `with_model`. Raises ProfileError where other places are told by other coordinates.
    """
    import tomlkit

    document, section = _parsed(text, file, axis)
    where = {name: value for name in COORDINATES if (value := getattr(place, name)) is not None}
    entries = section.get("at")
    if entries is None:
        entries = section["at"] = tomlkit.aot()
    for other in entries:
        told = [name for name in COORDINATES if name in other]
        if told != list(where):
            raise ProfileError(f"{file}: axis.{axis}.at: its places tell {', '.join(told)}, this one "
                               f"{', '.join(where)} (tell the same of each)")  # fmt: skip
    entry = next((one for one in entries if all(float(one[name]) == value for name, value in where.items())), None)
    if entry is None:
        entry = tomlkit.inline_table() if isinstance(entries, tomlkit.items.Array) else tomlkit.table()
        entry.update(where)
        _put(entry, place.model, note)
        if isinstance(entries, tomlkit.items.AoT):
            entry.add(tomlkit.nl())
        entries.append(entry)
    else:
        _put(entry, place.model, note)
    section["uncertainty"] = _spread_table(_wider(section.get("uncertainty"), spread))
    return tomlkit.dumps(document)


def _put(entry: dict[str, object], model: Model, note: str) -> None:
    """Model and note into one entry of [[axis.x.at]]; a model in a section of its own is changed there."""
    import tomlkit
    from tomlkit.items import Table

    entry["note"] = _one_line(note)
    old = entry.get("model")
    if isinstance(old, Table):
        _replace(old, model)
    else:
        row = tomlkit.inline_table()
        row.update(_model_values(model))
        entry["model"] = row


def _replace(table: dict[str, object], model: Model) -> None:
    """Another model in the same section."""
    for key in [key for key in table if key != "note"]:
        del table[key]
    table.update(_model_values(model))


def _wider(old: object, new: Spread) -> Spread:
    """Ranges that hold those of an [axis.x.uncertainty] and new ones; a family cannot go with places, and is left."""
    if not isinstance(old, dict) or "family" in old:
        return new
    (f, g), (c, d) = (old.get(key, (1.0, 1.0)) for key in ("frequency", "damping"))
    return Spread(
        (min(f, new.frequency[0]), max(g, new.frequency[1])), (min(c, new.damping[0]), max(d, new.damping[1]))
    )


def _parsed(text: str, file: str, axis: str) -> tuple[TOMLDocument, Table]:
    """The document and the axis' section in it."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
    except (TOMLKitError, ValueError, RecursionError) as why:
        raise ProfileError(f"{file}: not TOML: {' '.join(str(why).split())}") from None
    axes = document.get("axis")
    if not isinstance(axes, dict) or not isinstance(axes.get(axis), dict):
        raise ProfileError(f"{file}: axis.{axis} is missing (add [axis.{axis}] with travel and steps_per_mm)")
    return document, axes[axis]


def _model_values(model: Model) -> dict[str, object]:
    """The keys of [axis.x.model], in the order in which they are read best."""
    import tomlkit

    if isinstance(model, ModalModel):
        modes = tomlkit.array()
        for mode in model.modes:
            row = tomlkit.inline_table()
            row.update({"frequency": mode.frequency, "damping": mode.damping})
            if len(model.modes) > 1:
                row["gain"] = mode.gain
            modes.append(row)
        return {"modes": modes.multiline(len(model.modes) > 2)}
    if isinstance(model, TransferFunction):
        return {"b": list(model.b), "a": list(model.a), "dt": model.dt}
    raise ProfileError("only modes and transfer functions are written into a profile")


def _spread_table(spread: Spread | Family) -> object:
    import tomlkit

    table = tomlkit.table()
    if isinstance(spread, Spread):
        table["frequency"] = [_outwards(spread.frequency[0], floor), _outwards(spread.frequency[1], ceil)]
        table["damping"] = [_outwards(spread.damping[0], floor), _outwards(spread.damping[1], ceil)]
        return table
    family = tomlkit.array()
    for model, weight in zip(spread.models, spread.weights, strict=True):
        row = tomlkit.inline_table()
        row.update({**_model_values(model), "weight": round(weight, 6)})
        family.append(row)
    table["family"] = family.multiline(True)
    return table


def _outwards(value: float, to: Callable[[float], int]) -> float:
    return round(to(value / SHORT) * SHORT, 3)


def _one_line(text: str) -> str:
    """Text that a profile can hold between quotes."""
    return "".join(c for c in text if c.isprintable() and c not in '"\\').strip() or "unnamed"
