"""Plants and motions that the compensators' laws are tried on."""

from __future__ import annotations

import numpy as np

from fbfcli.control.axis_model import AxisModel, exactly
from fbfcli.plant.model import Plant, impulse_response, modes, plant_of
from fbfcli.printer import ModalModel, Mode, TransferFunction

DT = 1e-3
MODELS = {
    "taz6": TransferFunction(
        (0, 0.0874002643, -0.3414755673, 0.5118203207, -0.3480853557, 0.0906300805),
        (1, -4.5399420515, 8.2830579485, -7.5829420515, 3.4790579485, -0.6389420515), DT),
    "hictop": TransferFunction(
        (0, 0.0260166669, -0.0479750004, -0.0029833334, 0.0480250004, -0.0229833335),
        (1, -4.79178, 9.27422, -9.05978, 4.46622, -0.88878), DT),
    "35 Hz": ModalModel((Mode(35, 0.05),)),
    "28 Hz": ModalModel((Mode(28, 0.05),)),
    "45+85 Hz": ModalModel((Mode(45, 0.05, 0.8), Mode(85, 0.05, 0.2))),
}  # fmt: skip
PLANTS: dict[str, Plant] = {name: plant_of(model, DT, "x") for name, model in MODELS.items()}


def described(*names: str) -> tuple[list[AxisModel], float]:
    """What `design` takes of the named plants, one per axis."""
    plants = [PLANTS[name] for name in names]
    return [exactly(plant.b, plant.a, impulse_response(plant), modes(plant)) for plant in plants], DT


def family(f: float, zeta: float, spread: float, members: int) -> AxisModel:
    """An axis of one mode [Hz] that is known to +-spread: so many plants, equally probable."""
    plants = [plant_of(ModalModel((Mode(f * (1 + q), zeta),)), DT, "x") for q in np.linspace(-spread, spread, members)]
    nominal = plant_of(ModalModel((Mode(f, zeta),)), DT, "x")
    return AxisModel(nominal.b, nominal.a, impulse_response(nominal), modes(nominal),
                     tuple(impulse_response(plant) for plant in plants), np.full(members, 1 / members))  # fmt: skip


def answering(h: np.ndarray) -> AxisModel:
    """An axis of this impulse response, without a mode."""
    return exactly(h, np.ones(1), h, ())


def motion(seed: int, samples: int, axes: int = 2, hold: int = 18, offset: float = 100.0) -> np.ndarray:
    """From rest to rest by pulses of 5000 mm/s^2, at rest `hold` samples at both ends, shape (samples, axes) [mm]."""
    rng = np.random.default_rng(seed)
    a = np.zeros((samples, axes))
    k = hold
    while k < samples - hold - 20:
        half = int(rng.integers(5, min(60, (samples - hold - k) // 2)))
        push = 5000 * rng.uniform(-1, 1, axes)
        a[k : k + half] += push
        a[k + half : k + 2 * half] -= push
        k += 2 * half
    return offset + np.cumsum(np.cumsum(a, axis=0), axis=0) * DT**2


def commanded(compensator, y: np.ndarray, pieces: list[int] | None = None) -> np.ndarray:
    """The command of one stretch, pushed whole or in pieces of the given sizes (repeated)."""
    stream = compensator.start(y[0])
    sizes, out, k, turn = pieces or [len(y)], [], 0, 0
    while k < len(y):
        step = sizes[turn % len(sizes)]
        part = y[k : k + step]
        out.append(stream.push(part, np.ones(len(part)), k + step >= len(y)))
        k, turn = k + step, turn + 1
    return np.concatenate(out)
