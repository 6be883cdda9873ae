"""Pictures of what was identified: response and model with their uncertainty, and the recording over time."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import spectrogram

from fbfcli.plant.frf import Frf
from fbfcli.plant.rational import Rational, response

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DATA, MODEL, MODE = "#1f77b4", "#d62728", "#777777"
GROUPS = ("#2ca02c", "#9467bd", "#8c564b", "#e377c2", "#bcbd22", "#17becf")
NORMAL_95 = 1.96
POINTS = 800
WIDE_IN, PANEL_IN = 9.0, 2.3
SEGMENT_S = 0.5  # of the spectrogram
SEGMENTS = 8  # at least
HIGHEST_HZ = 250.0
RANGE_DB = 60.0


def bode_picture(
    title: str,
    frf: Frf,
    outside: tuple[float, float, float],
    model: Rational,
    possible: Sequence[Rational],
    modes: Sequence[float],
    groups: Sequence[tuple[str, Frf]],
    captures: Sequence[tuple[str, float, np.ndarray]],
    kind: str,
) -> bytes:
    """Magnitude, phase and coherence with the model over the data, and the spectrogram of each capture.

    outside  : gain, delay [s] and drift [s/Hz] that are the sensor's and the clocks'; taken out of the data
    possible : models as probable as the data leave them: the band
    modes    : frequencies that are marked [Hz]
    captures : (name, fs, y)
    kind     : png, svg or pdf
    """
    figure, panels = _figure(title, 3 + min(len(captures), 2))
    f = np.geomspace(max(1.0, 0.6 * frf.frequency[0]), min(1.3 * frf.frequency[-1], HIGHEST_HZ), POINTS)
    magnitude, phase, coherence = panels[:3]
    for axes in panels[:3]:
        axes.set_xscale("log")
        axes.set_xlim(f[0], f[-1])
        for mode in modes:
            axes.axvline(mode, color=MODE, lw=0.8, ls=":")
    for (label, group), color in zip(groups, GROUPS * len(groups), strict=False):
        magnitude.plot(group.frequency, np.abs(group.H) / outside[0], color=color, lw=0.8, alpha=0.8, label=label)
    _data(frf, outside, magnitude, phase)
    _model(f, model, possible, magnitude, phase)
    for mode in modes:
        magnitude.annotate(f"{mode:.1f} Hz", (mode, 1), xycoords=("data", "axes fraction"), fontsize=8, color=MODE,
                           xytext=(2, -10), textcoords="offset points")  # fmt: skip
    magnitude.set_ylabel("magnitude")
    magnitude.set_yscale("log")
    magnitude.legend(fontsize=7, loc="lower left")
    phase.set_ylabel("phase [deg]")
    coherence.plot(frf.frequency, frf.coherence, color=DATA, lw=1)
    coherence.set_ylim(0, 1.05)
    coherence.set_ylabel("coherence")
    coherence.set_xlabel("frequency [Hz]")
    for axes, (name, fs, y) in zip(panels[3:], captures, strict=False):
        _spectrogram(axes, name, fs, y)
    return _written(figure, kind)


def power_picture(title: str, f: np.ndarray, power: np.ndarray, rise: float, model: Rational, modes: Sequence[float],
                  kind: str) -> bytes:  # fmt: skip
    """A power spectrum and what the model makes of its excitation; the scale is fitted, there is no phase."""
    figure, (axes,) = _figure(title, 1)
    kept = (f > 1) & (f < HIGHEST_HZ) & (power > 0)
    shape = np.abs(response(model, f[kept])) ** 2 * f[kept] ** rise
    scale = np.exp(np.average(np.log(power[kept] / shape), weights=np.sqrt(power[kept])))
    axes.semilogy(f[kept], power[kept], color=DATA, lw=1, label="measured")
    axes.semilogy(f[kept], scale * shape, color=MODEL, lw=1.2, label="model, minimum phase assumed")
    for mode in modes:
        axes.axvline(mode, color=MODE, lw=0.8, ls=":")
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("power, any scale")
    axes.legend(fontsize=8)
    return _written(figure, kind)


def decay_picture(title: str, t: np.ndarray, y: np.ndarray, fitted: np.ndarray,
                  captures: Sequence[tuple[str, float, np.ndarray]], kind: str) -> bytes:  # fmt: skip
    """A ringing machine and the decaying modes fitted to it, and the spectrogram of the capture."""
    figure, panels = _figure(title, 1 + len(captures))
    panels[0].plot(t, y, color=DATA, lw=1, label="measured")
    panels[0].plot(t, fitted, color=MODEL, lw=1, label="decaying modes")
    panels[0].set_xlabel("time after the largest swing [s]")
    panels[0].set_ylabel("acceleration [mm/s²]")
    panels[0].legend(fontsize=8)
    for axes, (name, fs, samples) in zip(panels[1:], captures, strict=True):
        _spectrogram(axes, name, fs, samples)
    return _written(figure, kind)


def _data(frf: Frf, outside: tuple[float, float, float], magnitude: Axes, phase: Axes) -> None:
    """The lines with their 95 % bands; what is the sensor's and the clocks' is taken out."""
    gain, delay, drift = outside
    H = frf.H / gain * np.exp(2j * np.pi * frf.frequency * (delay + drift * frf.frequency))
    error = NORMAL_95 * frf.sd / gain
    size = np.abs(H)
    low = np.maximum(size - error, 1e-3 * size)
    magnitude.fill_between(frf.frequency, low, size + error, color=DATA, alpha=0.25, lw=0)
    magnitude.plot(frf.frequency, size, ".", ms=3, color=DATA, label="measured, 95 %")
    angle = np.degrees(np.unwrap(np.angle(H)))
    wide = np.degrees(np.arcsin(np.minimum(error / size, 1)))
    phase.fill_between(frf.frequency, angle - wide, angle + wide, color=DATA, alpha=0.25, lw=0)
    phase.plot(frf.frequency, angle, ".", ms=3, color=DATA)


def _model(f: np.ndarray, model: Rational, possible: Sequence[Rational], magnitude: Axes, phase: Axes) -> None:
    H = response(model, f)
    magnitude.plot(f, np.abs(H), color=MODEL, lw=1.2, label="model")
    phase.plot(f, np.degrees(np.unwrap(np.angle(H))), color=MODEL, lw=1.2)
    if possible:
        band = np.array([response(one, f) for one in possible])
        low, high = np.percentile(np.abs(band), [2.5, 97.5], axis=0)
        magnitude.fill_between(f, low, high, color=MODEL, alpha=0.2, lw=0)
        turned = np.degrees(np.angle(band / H))
        low, high = np.degrees(np.unwrap(np.angle(H))) + np.percentile(turned, [2.5, 97.5], axis=0)
        phase.fill_between(f, low, high, color=MODEL, alpha=0.2, lw=0)


def _spectrogram(axes: Axes, name: str, fs: float, y: np.ndarray) -> None:
    size = max(8, min(int(SEGMENT_S * fs), len(y) // SEGMENTS))
    f, t, power = spectrogram(y, fs, "hann", size, size // 2)
    kept = f < HIGHEST_HZ
    level = 10 * np.log10(power[kept] / power[kept].max() + 1e-12)
    mesh = axes.pcolormesh(t, f[kept], level, vmin=-RANGE_DB, vmax=0, cmap="magma", rasterized=True)
    axes.figure.colorbar(mesh, ax=axes, label="dB", pad=0.01)
    axes.set_xlabel(f"time [s], {name}")
    axes.set_ylabel("frequency [Hz]")


def _figure(title: str, panels: int) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDE_IN, PANEL_IN * panels + 0.6), layout="constrained")
    figure.suptitle(title, fontsize=10)
    axes = np.atleast_1d(figure.subplots(panels, 1))
    for one in axes:
        one.grid(True, which="both", lw=0.3, alpha=0.5)
    return figure, list(axes)


def _written(figure: Figure, kind: str) -> bytes:
    stream = BytesIO()
    figure.savefig(stream, format=kind, dpi=110)
    return stream.getvalue()
