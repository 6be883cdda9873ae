"""What a profile says of two axes that move each other: [axis.x.coupling]."""

from __future__ import annotations

from typing import Protocol

from fbfcli.printer import ModalModel, Model, TransferFunction
from fbfcli.toml_table import Table

SUM_TOLERANCE = 1e-3  # of the sum of b, a part of its largest coefficient: digits that people write


class ModelOf(Protocol):
    """Reads a model whose gain at rest is `gain`."""

    def __call__(self, inner: Table, gain: float) -> Model: ...


def coupling(axis: Table, model_of: ModelOf) -> ModalModel | TransferFunction:
    """[axis.x.coupling]: from Y's command to what it adds to X, nothing at rest. Raises ProfileError."""
    table = axis.table("coupling").only("modes", "b", "a", "dt")
    if "model" not in axis.values and "at" not in axis.values:
        axis.refuse("coupling", "is there without a model", f"add a section [{axis.where('model')}]")
    model = model_of(table, 0.0)
    assert isinstance(model, ModalModel | TransferFunction)
    if isinstance(model, TransferFunction) and abs(sum(model.b)) > SUM_TOLERANCE * max(map(abs, model.b)):
        table.refuse("b", f"sums to {sum(model.b):g}, not 0", "at rest the other axis moves nothing")
    return model
