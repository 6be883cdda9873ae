"""The order of the steps from recordings to a model: read, align, respond, fit, and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fbfcli.errors import ModelError, RecordingError
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.conclusions import concluded, klipper_choice
from fbfcli.pipeline.identified import Capture, Identified, Measured
from fbfcli.plant.alignment import Pair, paired
from fbfcli.plant.fit import Candidate, candidates
from fbfcli.plant.free_decay import free_decay
from fbfcli.plant.frf import Frf, combined, frf, from_table, trusted
from fbfcli.plant.intervals import ModeEstimate, covariance, draws, mode_estimates, told_modes
from fbfcli.plant.mechanical_hints import hints_of_groups, hints_of_modes, hints_of_response
from fbfcli.plant.power_fit import power_fit
from fbfcli.plant.rational import profile_model
from fbfcli.plant.recording import PowerSpectrum, Recording, ResponseTable
from fbfcli.plant.recordings import read_recordings
from fbfcli.plant.shape import model_of
from fbfcli.plant.shaper_score import klipper_spectrum, normalised
from fbfcli.plant.spectra import AVERAGING, Spectra, window_seconds
from fbfcli.plant.spread import group_fits, group_spread, noise_spread

CLOCK_FOUND, CLOCK_GIVEN = 2e-6, 5e-5  # standard deviation of a clock that was found here, and of a recorded pair's
KLIPPER_RISE = 2.0  # of the power of an acceleration that grows with frequency
MINIMUM_PHASE = "minimum phase (the recording holds no phase)"
RINGING = "gains from a free decay, minimum phase (nothing is known of the command)"
DRAWS, SEED = 12, 1
MODE_SHARE = 0.02  # of the strongest mode's peak: weaker ones are no modes worth telling


def identify(files: Sequence[tuple[str, bytes]], ask: Ask) -> Identified:
    """The model of one axis from one or more recordings (name, content). Raises RecordingError, ModelError."""
    reads = [one for name, data in files for one in read_recordings(data, name, ask.read)]
    kinds = {type(one) for one in reads}
    names = tuple(name for name, _ in files)
    if len(kinds) > 1 or (len(reads) > 1 and kinds != {Recording}):
        raise RecordingError("several files of different kinds, or several spectra", file=", ".join(names),
                             remedy="captures are combined, everything else is identified one by one")  # fmt: skip
    first = reads[0]
    if isinstance(first, PowerSpectrum):
        return _from_power(first, ask)
    if isinstance(first, ResponseTable):
        return _from_table(first, ask)
    return identify_captures([one for one in reads if isinstance(one, Recording)], ask)


def identify_captures(captures: Sequence[Recording], ask: Ask) -> Identified:
    """The same from captures that have been read. Raises RecordingError, ModelError."""
    try:
        pairs = [paired(one, ask.sweep, ask.axis) for one in captures]
    except RecordingError as unknown:
        if len(captures) > 1 or ask.sweep or captures[0].command is not None:
            raise
        return _from_decay(captures[0], ask, unknown)
    return _from_pairs(captures, pairs, ask)


def _from_pairs(captures: Sequence[Recording], pairs: Sequence[Pair], ask: Ask) -> Identified:
    axes = {pair.axis for pair in pairs}
    if len(axes) > 1:
        raise RecordingError(
            "recordings of both axes", file=", ".join(c.name for c in captures), remedy="give one --axis"
        )
    axis = axes.pop()
    low, high = ask.band
    ends = [pair.sweep.f1 for pair in pairs if pair.sweep is not None]
    band = low, min([high, *ends])
    labels, groups = _groups(captures, pairs, axis, band, ask)
    response = trusted(_drifting(frf(combined(groups), ask.estimator, _amplitude(pairs)), pairs))
    found = _fitted(response, [c.name for c in captures])
    best, cov = found[0], covariance(response, found[0])
    apart = [trusted(_drifting(frf(group, ask.estimator), pairs)) for group in groups] if len(groups) > 1 else []
    fits = group_fits(apart, best)
    modes = _worth_telling(told_modes(response, found))
    rational = model_of(best.shape, best.theta)
    off_axis = [
        (name, _off_axis(pairs[0], name, axis, band, ask)) for name in pairs[0].columns if name not in (axis, "z")
    ]
    strongest = [mode_estimates(fit, np.zeros_like(cov))[0].frequency.value for fit in fits]
    hints = (
        *hints_of_response(response, off_axis, float(np.exp(best.theta[0]))),
        *hints_of_modes(modes),
        *(hints_of_groups(labels, strongest) if len(strongest) == len(labels) else ()),
    )
    possible = [profile_model(one, ask.dt) for one in draws(best, cov, DRAWS, np.random.default_rng(SEED))]
    possible += [profile_model(model_of(fit.shape, fit.theta), ask.dt) for fit in fits]
    told = concluded(axis, [c.name for c in captures], "", rational, modes, ask, possible,
                  _klipper_sees(captures[0], pairs[0], response, off_axis))  # fmt: skip
    return replace(
        told,
        spread=group_spread(fits, ask.dt) if len(fits) > 1 else noise_spread(modes),
        notes=tuple(dict.fromkeys(note for pair in pairs for note in pair.notes)),
        hints=hints,
        measured=Measured(response, tuple(zip(labels, apart, strict=False)), found, cov),
        captures=tuple(
            Capture(c.name, p.fs, p.response[:, p.columns.index(axis)]) for c, p in zip(captures, pairs, strict=True)
        ),
    )


def _groups(
    captures: Sequence[Recording], pairs: Sequence[Pair], axis: str, band: tuple[float, float], ask: Ask
) -> tuple[list[str], list[Spectra]]:
    """Spectra of each recording, and of each amplitude in it, with their labels."""
    parts = [
        (f"{capture.name}{f' at {amplitude:g} mm/s^2' if amplitude else ''}", pair, slice(begin, end))
        for capture, pair in zip(captures, pairs, strict=True)
        for begin, end, amplitude in pair.segments or ((0, len(pair.command), 0.0),)
    ]
    seconds = window_seconds(min((part.stop - part.start) / pair.fs for _, pair, part in parts))
    averaged = AVERAGING[ask.averaging]
    return [label for label, _, _ in parts], [
        averaged(pair.command[part], pair.response[part, pair.columns.index(axis)], pair.fs, band, seconds)
        for _, pair, part in parts
    ]


def _fitted(response: Frf, names: Sequence[str]) -> tuple[Candidate, ...]:
    """Shapes fitted, the chosen one first; errors get the files' names."""
    try:
        return candidates(response)
    except ModelError as error:
        raise RecordingError(str(error), file=", ".join(names)) from None


def _off_axis(pair: Pair, name: str, axis: str, band: tuple[float, float], ask: Ask) -> Frf:
    """How another column answers the command of this axis."""
    return trusted(
        frf(AVERAGING[ask.averaging](pair.command, pair.response[:, pair.columns.index(name)], pair.fs, band))
    )


def _klipper_sees(
    capture: Recording, pair: Pair, response: Frf, off_axis: Sequence[tuple[str, Frf]]
) -> tuple[np.ndarray, np.ndarray]:
    """The spectrum that Klipper scores shapers on: of its own test, or what its test would show of this response."""
    if pair.sweep is not None and pair.sweep.name.startswith("Klipper"):
        f, psd = klipper_spectrum(capture.measured, capture.fs)
        return f, normalised(f, psd)
    f = response.frequency
    return f, f * sum(
        np.interp(f, r.frequency, np.abs(r.H) ** 2) for r in (response, *(r for _, r in off_axis if len(r.H)))
    )


def _drifting(response: Frf, pairs: Sequence[Pair]) -> Frf:
    """The response, told how far its clock may be off: so many seconds later for each Hz that a sweep rises."""
    f = response.frequency
    if len(f) < 2:
        return response
    duration = max(len(pair.command) / pair.fs for pair in pairs)
    clock = CLOCK_FOUND if all(pair.sweep is not None for pair in pairs) else CLOCK_GIVEN
    return replace(response, drift=clock * duration / float(f[-1] - f[0]))


def _amplitude(pairs: Sequence[Pair]) -> float:
    moving = np.concatenate([pair.command[pair.command != 0] for pair in pairs])
    return float(np.sqrt(np.mean(moving**2))) if len(moving) else float("nan")


def _from_table(table: ResponseTable, ask: Ask) -> Identified:
    """A response that somebody measured: fitted as ours is, or by its magnitude where it has no phase."""
    axis = _axis(table.axis, table.name, ask)
    if not table.has_phase:
        return _from_magnitude(table.name, axis, table.frequency, np.abs(table.response) ** 2, 0.0, table.notes, ask)
    response = from_table(table.frequency, table.response, table.coherence)
    found = _fitted(response, [table.name])
    best, cov = found[0], covariance(response, found[0])
    modes = _worth_telling(told_modes(response, found))
    possible = [profile_model(one, ask.dt) for one in draws(best, cov, DRAWS, np.random.default_rng(SEED))]
    told = concluded(axis, [table.name], "", model_of(best.shape, best.theta), modes, ask, possible, None)
    hints = (*hints_of_response(response, (), float(np.exp(best.theta[0]))), *hints_of_modes(modes))
    return replace(told, notes=table.notes, hints=hints, measured=Measured(response, (), found, cov))


def _from_power(spectrum: PowerSpectrum, ask: Ask) -> Identified:
    """Klipper's power spectrum: of the axis' own column, or of the sum where the axis is not told."""
    axis = _axis(None, spectrum.name, ask)
    column = axis if axis in spectrum.columns else "xyz"
    if column not in spectrum.columns:
        raise RecordingError(f"no power of axis {axis}", file=spectrum.name, remedy="choose another --axis")
    # a file that Klipper has scored shapers on holds the power over frequency already
    rise = KLIPPER_RISE - 1.0 if spectrum.shapers else KLIPPER_RISE
    power = spectrum.power[:, spectrum.columns.index(column)]
    found = _from_magnitude(spectrum.name, axis, spectrum.frequency, power, rise, spectrum.notes, ask)
    total = spectrum.power[:, spectrum.columns.index("xyz")] if "xyz" in spectrum.columns else power
    psd = total if spectrum.shapers else normalised(spectrum.frequency, total)
    shaper, kinds, most = klipper_choice((spectrum.frequency, psd))
    return replace(found, shaper=shaper, shapers=kinds, shaper_acceleration=most)


def _from_magnitude(
    name: str, axis: str, f: np.ndarray, power: np.ndarray, rise: float, notes: tuple[str, ...], ask: Ask
) -> Identified:
    kept = (f >= max(ask.band[0], 10.0 if rise else 0.0)) & (f <= ask.band[1])  # Klipper fades what is below 10 Hz
    try:
        fit = power_fit(f[kept], power[kept], rise)[0]
    except ModelError as error:
        raise RecordingError(str(error), file=name, remedy="record a test of the whole band") from None
    told = concluded(axis, [name], MINIMUM_PHASE, fit.model, fit.modes, ask, None, None)
    return replace(told, notes=notes, hints=hints_of_modes(fit.modes), power=(f, power, rise))


def _from_decay(capture: Recording, ask: Ask, unknown: RecordingError) -> Identified:
    """A machine that rings by itself: nothing is known of what set it ringing."""
    axis = _axis(capture.axis, capture.name, ask)
    if axis not in capture.columns:
        raise RecordingError(f"no measurement of axis {axis}", file=capture.name, remedy="choose another --axis")
    try:
        fit = free_decay(capture.measured[:, capture.columns.index(axis)], capture.fs)
    except ModelError as error:
        raise RecordingError(f"{unknown}; and as a free decay: {error}") from None
    told = concluded(axis, [capture.name], RINGING, fit.model, fit.modes, ask, None, None)
    captures = (Capture(capture.name, capture.fs, capture.measured[:, capture.columns.index(axis)]),)
    return replace(told, notes=capture.notes, hints=hints_of_modes(fit.modes), decay=fit, captures=captures)


def _axis(told: str | None, name: str, ask: Ask) -> str:
    axis = ask.axis or told
    if axis is None:
        raise RecordingError("the file does not tell which axis was moved", file=name, remedy="give --axis")
    return axis


def _worth_telling(modes: tuple[ModeEstimate, ...]) -> tuple[ModeEstimate, ...]:
    heights = [abs(mode.gain.value) / mode.damping.value for mode in modes]
    return tuple(mode for mode, height in zip(modes, heights, strict=True) if height > MODE_SHARE * max(heights))
