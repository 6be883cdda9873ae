"""The order of the steps from recordings to a model: read, align, respond, fit, and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fbfcli.errors import ModelError, RecordingError
from fbfcli.pipeline.ask import Ask
from fbfcli.pipeline.conclusions import concluded, klipper_choice
from fbfcli.pipeline.identified import Capture, Identified, Measured
from fbfcli.pipeline.responses import band_of, fitted, responses
from fbfcli.plant.alignment import Pair, paired
from fbfcli.plant.candidate import Candidate
from fbfcli.plant.free_decay import free_decay
from fbfcli.plant.frf import Frf, frf, from_table, trusted
from fbfcli.plant.intervals import ModeEstimate, covariance, draws, told_modes
from fbfcli.plant.mechanical_hints import hints_of_groups, hints_of_modes, hints_of_response
from fbfcli.plant.power_fit import power_fit
from fbfcli.plant.rational import profile_model
from fbfcli.plant.recording import PowerSpectrum, Recording, ResponseTable
from fbfcli.plant.recordings import read_recordings
from fbfcli.plant.shape import model_of
from fbfcli.plant.shaper_score import klipper_spectrum, normalised
from fbfcli.plant.spectra import AVERAGING
from fbfcli.plant.spread import group_fits, group_spread, strongest_frequencies

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
    names = [capture.name for capture in captures]
    axes = {pair.axis for pair in pairs}
    if len(axes) > 1:
        raise RecordingError("recordings of both axes", file=", ".join(names), remedy="give one --axis")
    axis = axes.pop()
    answer = responses(names, pairs, ask)
    off_axis = [(name, _off_axis(pairs[0], name, ask)) for name in pairs[0].columns if name not in (axis, "z")]
    seen = _klipper_sees(captures[0], pairs[0], answer.together, off_axis)
    fits = group_fits(answer.apart, answer.found[0])
    told = _from_response(axis, names, answer.together, answer.found, fits, off_axis, seen, ask)
    if len(fits) == len(answer.labels) > 0:
        told = replace(told, hints=(*told.hints, *hints_of_groups(answer.labels, strongest_frequencies(fits))))
    assert told.measured is not None
    return replace(
        told,
        spread=group_spread(fits, ask.dt) if len(fits) > 1 else told.spread,
        notes=tuple(dict.fromkeys(note for pair in pairs for note in pair.notes)),
        measured=replace(told.measured, frf=answer.shown, groups=tuple(zip(answer.labels, answer.apart, strict=True))),
        captures=tuple(Capture(name, pair.fs, pair.measured) for name, pair in zip(names, pairs, strict=True)),
    )


def _from_response(
    axis: str, names: Sequence[str], response: Frf, found: tuple[Candidate, ...], fits: Sequence[Candidate],
    off_axis: Sequence[tuple[str, Frf]], psd: tuple[np.ndarray, np.ndarray] | None, ask: Ask,
) -> Identified:  # fmt: skip
    """What follows from a complex response and its models; `fits`: of its parts by themselves."""
    best, cov = found[0], covariance(response, found[0])
    modes = _worth_telling(told_modes(response, found))
    likely = [*draws(best, cov, DRAWS, np.random.default_rng(SEED)), *(model_of(fit.shape, fit.theta) for fit in fits)]
    possible = [profile_model(one, ask.dt) for one in likely]
    told = concluded(axis, names, "", model_of(best.shape, best.theta), modes, ask, possible, psd)
    hints = (*hints_of_response(response, off_axis, float(np.exp(best.theta[0]))), *hints_of_modes(modes))
    return replace(told, hints=hints, measured=Measured(response, (), found, cov))


def _off_axis(pair: Pair, name: str, ask: Ask) -> Frf:
    """How another column answers the command of this axis."""
    answer = pair.response[:, pair.columns.index(name)]
    return trusted(frf(AVERAGING[ask.averaging](pair.command, answer, pair.fs, band_of([pair], ask))))


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


def _from_table(table: ResponseTable, ask: Ask) -> Identified:
    """A response that somebody measured: fitted as ours is, or by its magnitude where it has no phase."""
    axis = _axis(table.axis, table.name, ask)
    if not table.has_phase:
        return _from_magnitude(table.name, axis, table.frequency, np.abs(table.response) ** 2, 0.0, table.notes, ask)
    response = from_table(table.frequency, table.response, table.coherence)
    found = fitted(response, [table.name])
    return replace(_from_response(axis, [table.name], response, found, (), (), None, ask), notes=table.notes)


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
