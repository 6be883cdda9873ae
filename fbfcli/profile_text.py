"""A printer profile as text: what was measured of one axis goes in, everything that people wrote stays as it is."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, floor

from fbfcli.errors import ProfileError
from fbfcli.printer import Family, ModalModel, Model, Spread, TransferFunction

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
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
    except (TOMLKitError, ValueError, RecursionError) as why:
        raise ProfileError(f"{file}: not TOML: {' '.join(str(why).split())}") from None
    axes = document.get("axis")
    if not isinstance(axes, dict) or not isinstance(axes.get(axis), dict):
        raise ProfileError(f"{file}: axis.{axis} is missing (add [axis.{axis}] with travel and steps_per_mm)")
    section = axes[axis]
    old = section.get("model")
    if isinstance(old, dict):  # changed in place: comments around the section stay where they are
        for key in [key for key in old if key != "note"]:
            del old[key]
        table = old
    else:
        table = tomlkit.table()
        section["model"] = table
    table["note"] = _one_line(note)
    for key, value in _model_values(model).items():
        table[key] = value
    if spread is None:
        section.pop("uncertainty", None)
    else:
        section["uncertainty"] = _spread_table(spread)
        if not old:
            section["uncertainty"].add(tomlkit.nl())
    return tomlkit.dumps(document)


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
