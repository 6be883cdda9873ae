"""What was identified of one axis, and how it is told."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import PurePath

import numpy as np

from fbfcli.pipeline.rows import row
from fbfcli.plant.candidate import Candidate
from fbfcli.plant.free_decay import FreeDecay
from fbfcli.plant.frf import Frf
from fbfcli.plant.intervals import ModeEstimate
from fbfcli.plant.rational import Rational, zeros
from fbfcli.plant.shaper_score import Scored
from fbfcli.plant.spread import as_ranges
from fbfcli.printer import Family, Model, Spread
from fbfcli.units import UM_PER_MM

OSCILLATING = 0.7  # damping above which a pole pair is told as a lag, not as a mode
CERTAIN = 0.8  # of the model's own figure: worse ones are told beside it
WORTH = 1.5  # times: where compensation is certain to gain less, the model says little, and that is told
SHOWN = 6  # rows of the table of orders


@dataclass(frozen=True)
class Capture:
    """One recording as its spectrogram shows it: samples y, shape (n,) [mm/s^2], at fs [Hz]."""

    name: str
    fs: float
    y: np.ndarray


@dataclass(frozen=True)
class Measured:
    """A complex response and what was fitted to it.

    frf        : all recordings together
    groups     : (label, response) of each run or amplitude by itself, where there are several
    candidates : shapes fitted, the chosen one first
    covariance : of its theta
    """

    frf: Frf
    groups: tuple[tuple[str, Frf], ...]
    candidates: tuple[Candidate, ...]
    covariance: np.ndarray


@dataclass(frozen=True)
class Identified:
    """One axis.

    axis      : 'x' or 'y'
    source    : names of the recordings
    assumed   : what is assumed and not measured, empty where nothing is
    model     : as the profile holds it; rational: the same in continuous time
    modes     : strongest first
    spread    : what is uncertain
    notes     : what was repaired or found in the recordings;  hints: what looks mechanically wrong
    shaper    : Klipper's choice, None where nothing of a spectrum is known; shapers: of each kind
    error     : [mm], within which motion stays up to these accelerations [mm/s^2]: uncompensated by the model itself,
                and by the worst of those that it may be; compensated likewise, None if not known
    """

    axis: str
    source: tuple[str, ...]
    assumed: str
    model: Model
    rational: Rational
    modes: tuple[ModeEstimate, ...]
    spread: Spread | Family
    notes: tuple[str, ...]
    hints: tuple[str, ...]
    shaper: Scored | None
    shapers: tuple[Scored, ...]
    shaper_acceleration: float
    error: float
    by_model: float
    uncompensated: float
    compensated: float | None
    measured: Measured | None = None
    power: tuple[np.ndarray, np.ndarray, float] | None = None
    decay: FreeDecay | None = None
    captures: tuple[Capture, ...] = ()

    @property
    def ranges(self) -> Spread:
        """What is uncertain, as ranges: a profile with models at places takes no family."""
        return as_ranges(self.spread, self.model)

    def note(self) -> str:
        """Where the model comes from, on one line, for the profile."""
        label = f"; {self.assumed}" if self.assumed else ""
        return f"fbf identify {', '.join(PurePath(name).name for name in self.source)}{label}"

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        found: dict[str, object] = {
            "axis": self.axis,
            "source": list(self.source),
            "assumed": self.assumed,
            "model": {"form": type(self.model).__name__, **asdict(self.model)},
            "modes": [asdict(mode) for mode in self.modes],
            "zeros": [
                {"re": z.real, "im": z.imag, "nonminimum_phase": z.real > 0} for z in zeros(self.rational).tolist()
            ],
            "uncertainty": {"form": type(self.spread).__name__, **asdict(self.spread)},
            "klipper_shaper": asdict(self.shaper) if self.shaper else None,
            "klipper_shapers": [asdict(one) for one in self.shapers],
            "within_mm": self.error,
            "acceleration_by_model": self.by_model,
            "acceleration_uncompensated": self.uncompensated,
            "acceleration_compensated": self.compensated,
            "acceleration_shaper": self.shaper_acceleration if self.shaper else None,
            "notes": list(self.notes),
            "hints": list(self.hints),
        }
        return found | (_response_dict(self.measured) if self.measured else {})

    def text(self) -> str:
        """For people, on stderr."""
        rows = [("axis", f"{self.axis}, from {', '.join(PurePath(name).name for name in self.source)}")]
        rows += [("assumed", self.assumed)] * bool(self.assumed)
        rows += [("mode", _mode_text(mode)) for mode in self.modes if mode.damping.value < OSCILLATING]
        rows += _fit_rows(self) + _advice_rows(self)
        lines = [row(*each) for each in rows] + [f"note: {note}" for note in self.notes]
        return "\n".join(lines + [f"warning: {hint}" for hint in self.hints])


def _mode_text(mode: ModeEstimate) -> str:
    f, z, g = mode.frequency, mode.damping, mode.gain
    return (f"{f.value:.2f} Hz ({f.low:.2f} to {f.high:.2f}), damping {z.value:.4f} ({z.low:.4f} to {z.high:.4f}), "
            f"gain {g.value:.3f}")  # fmt: skip


def _fit_rows(found: Identified) -> list[tuple[str, str]]:
    if found.measured is None:
        return []
    frf, best = found.measured.frf, found.measured.candidates[0]
    gain, delay, drift = np.exp(best.theta[0]), 1e3 * best.theta[1], best.theta[2]
    unstable = [z for z in zeros(found.rational) if z.real > 0 and abs(z) < 2 * np.pi * 2 * frf.frequency[-1]]
    rows = [
        ("response", f"{len(frf.H)} lines, {frf.frequency[0]:.1f} to {frf.frequency[-1]:.1f} Hz, "
                     f"coherence {np.median(frf.coherence):.3f} (median)"),
        ("fit", f"{best.shape}: {100 * best.misfit:.1f} % left over"),
        ("beside it", f"sensor's gain {gain:.3f}, delay {delay:+.2f} ms, clock {1e6 * drift:+.2f} us/Hz: not in it"),
    ]  # fmt: skip
    rows += [
        ("zero", f"{abs(z) / (2 * np.pi):.1f} Hz is outside the stable region: its exact inverse would be unstable")
        for z in unstable
        if z.imag >= 0
    ]
    orders = sorted(found.measured.candidates, key=lambda c: c.shape.size)
    if len(orders) > 1:
        chosen = [f"{c.shape} {c.criterion:.0f}{' *' if c is best else ''}" for c in found.measured.candidates[:SHOWN]]
        rows.append(("orders", "; ".join(chosen) + " (information criterion, * chosen)"))
    return rows


def _advice_rows(found: Identified) -> list[tuple[str, str]]:
    um = UM_PER_MM * found.error
    as_it_is = f"up to {_accel(found.by_model)} as it is, after a change of acceleration"
    if found.uncompensated < CERTAIN * found.by_model:
        as_it_is += f"; {_accel(found.uncompensated)} at worst, as far as the model is uncertain"
    rows = [(f"within {um:.0f} um", as_it_is)]
    if found.compensated is not None:
        rows.append(("", f"up to {_accel(found.compensated)} compensated, at worst, as far as the model is uncertain"))
        if found.compensated < WORTH * found.uncompensated:
            rows.append(("", "this recording leaves too open how far the axis lags at low frequencies: not that "
                             "compensation gains nothing; shake harder, or record again"))  # fmt: skip
    if found.shaper:
        s = found.shaper
        rows.append(("Klipper's", f"{s.name} at {s.frequency:.1f} Hz: {100 * s.vibrations:.1f} % vibration left, "
                     f"smoothing {s.smoothing:.3f} mm, suggested acceleration up to "
                     f"{_accel(found.shaper_acceleration)}"))  # fmt: skip
    return rows


def _accel(value: float) -> str:
    return f"{value:,.0f} mm/s^2" if value < 1e5 else "more than 100,000 mm/s^2"


def _response_dict(measured: Measured) -> dict[str, object]:
    frf, best = measured.frf, measured.candidates[0]
    return {
        "fit": {
            "shape": str(best.shape),
            "misfit": best.misfit,
            "sensor_gain": float(np.exp(best.theta[0])),
            "delay": float(best.theta[1]),
            "drift": float(best.theta[2]),
            "orders": [
                {"shape": str(c.shape), "criterion": c.criterion, "misfit": c.misfit} for c in measured.candidates
            ],
        },
        "response": {
            "frequency": frf.frequency.tolist(),
            "magnitude": np.abs(frf.H).tolist(),
            "phase": np.angle(frf.H).tolist(),
            "coherence": frf.coherence.tolist(),
            "sd": frf.sd.tolist(),
        },
        "groups": [label for label, _ in measured.groups],
    }
