"""Executions whose errors are known, or can be found another way."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from fbfcli.plant.model import plant_of
from fbfcli.printer import ModalModel, Mode
from fbfcli.verify.execution import Execution
from fbfcli.verify.passage import Passage
from fbfcli.verify.simulate import BA

DT = 1e-3
RIGID = [(np.ones(1), np.ones(1))] * 2


def mode(frequency: float, damping: float, dt: float = DT) -> list[BA]:
    """X and Y of one mode each."""
    plant = plant_of(ModalModel((Mode(frequency, damping),)), dt, "x")
    return [(plant.b, plant.a)] * 2


def execution(
    desired: np.ndarray, begin=(0,), rest=None, goes_on: bool = False, dt: float = DT, **columns
) -> Execution:
    """A path (n, 2) that is executed as it is desired, extruding throughout; other columns as given."""
    n = len(desired)
    none = np.zeros(n, dtype=np.int64)
    motion = np.column_stack([desired, np.zeros(n), 0.03 * way(desired)])
    usual = {"time": dt * np.arange(n), "line": none, "layer": none, "feature": none, "desired": desired,
             "command": desired, "motion": motion, "extruding": np.ones(n, dtype=bool)}  # fmt: skip
    begin = np.asarray(begin, dtype=np.int64)
    rest = np.zeros(len(begin), dtype=np.int64) if rest is None else np.asarray(rest, dtype=np.int64)
    return Execution(dt=dt, begin=begin, rest=rest, goes_on=goes_on, **{**usual, **columns})


def way(path: np.ndarray) -> np.ndarray:
    """Length of a path up to each of its points."""
    return np.cumsum(np.hypot(*np.diff(path, axis=0, prepend=path[:1]).T))


def wandering(seed: int, n: int, starts: list[int]) -> Execution:
    """n samples of smooth random motion in several stretches, each from where the one before ended."""
    rng = np.random.default_rng(seed)
    steps = np.cumsum(rng.normal(0, 0.01, (n, 2)), axis=0)
    begin = np.unique([0, *starts])
    for a, b in zip(begin, np.append(begin[1:], n), strict=True):
        steps[a:b] *= np.sin(np.pi * np.linspace(0, 1, b - a))[:, None]
    rest = rng.integers(0, 40, len(begin))
    columns = {"line": np.cumsum(rng.random(n) < 0.05), "layer": np.cumsum(rng.random(n) < 0.01),
               "extruding": np.repeat(rng.random(n // 20 + 1) < 0.7, 20)[:n]}  # fmt: skip
    return execution(100.0 + np.cumsum(steps, axis=0), begin, rest, **columns)


def cut(whole: Execution, a: int, b: int) -> Execution:
    """Samples a to b of an execution."""
    here = (whole.begin >= a) & (whole.begin < b)
    rows = {name: getattr(whole, name)[a:b] for name in row_names() if getattr(whole, name) is not None}
    goes_on = b < len(whole) and b not in whole.begin
    return Execution(dt=whole.dt, begin=whole.begin[here] - a, rest=whole.rest[here], goes_on=goes_on, **rows)


def row_names() -> list[str]:
    return [field.name for field in fields(Execution) if field.name not in ("dt", "begin", "rest", "goes_on")]


def joined(passages: list[Passage]) -> Passage:
    """Passages one after the other as one."""
    at = np.cumsum([0] + [len(each) for each in passages])
    parts = [each.execution for each in passages]
    rows = {name: np.concatenate([getattr(part, name) for part in parts]) for name in row_names()
            if getattr(parts[0], name) is not None}  # fmt: skip
    begin = np.concatenate([part.begin + k for part, k in zip(parts, at, strict=False)])
    whole = Execution(dt=parts[0].dt, begin=begin, rest=np.concatenate([part.rest for part in parts]),
                      goes_on=parts[-1].goes_on, **rows)  # fmt: skip
    columns = {name: np.concatenate([getattr(each, name) for each in passages])
               for name in ("nozzle", "tracking", "contour", "across", "along")}  # fmt: skip
    return Passage(execution=whole, **columns)
