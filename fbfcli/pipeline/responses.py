"""The order of the steps from pairs of command and measurement to responses and the shapes that fit them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fbfcli.errors import ModelError, RecordingError
from fbfcli.pipeline.ask import Ask
from fbfcli.plant.alignment import Pair
from fbfcli.plant.candidate import Candidate
from fbfcli.plant.fit import candidates, candidates_again, nearer, refitted
from fbfcli.plant.frf import Frf, combined, frf, shifts, trusted
from fbfcli.plant.rehearsal import MOST, delayed, is_settled, left_over, steadied, without_windows
from fbfcli.plant.spectra import AVERAGING, Spectra, window_seconds

CLOCK_FOUND, CLOCK_GIVEN = 2e-6, 5e-5  # standard deviation of a clock that was found here, and of a recorded pair's


@dataclass(frozen=True)
class Part:
    """A recording, or the stretch of one amplitude in it: the `index`-th pair's samples in `samples`."""

    label: str
    index: int
    samples: slice


@dataclass(frozen=True)
class Responses:
    """Responses of all recordings together and of each part by itself, where there are several.

    together      : what models are fitted to;  shown: with less noise, where it has much
    labels, apart : of each part
    found         : shapes fitted to all together, the chosen one first
    """

    together: Frf
    shown: Frf
    labels: tuple[str, ...]
    apart: tuple[Frf, ...]
    found: tuple[Candidate, ...]


def responses(names: Sequence[str], pairs: Sequence[Pair], ask: Ask) -> Responses:
    """The response that recordings of one axis have, rid of what windows do to it, and its models.

    Raises RecordingError where no model fits.
    """
    band = band_of(pairs, ask)
    parts = _parts(names, pairs)
    measured = _spectra(parts, pairs, [pairs[part.index].measured for part in parts], band, ask)
    later = shifts(measured)
    seen = _drifting(frf(combined(measured, later), ask.estimator, _amplitude(pairs)), pairs)
    alone = [_drifting(frf(one, ask.estimator), pairs) for one in measured]
    found = fitted(trusted(seen), names)
    if ask.estimator == "h1":
        response, apart = _rehearsed(parts, pairs, later, (seen, *alone), found[0], band, ask)
        found = candidates_again(response, found)
        shown = steadied(response, found[0])
    else:  # a rehearsal knows no noise in the command
        response, apart = trusted(seen), tuple(map(trusted, alone))
        shown = response
    several = len(parts) > 1
    labels = tuple(part.label for part in parts) if several else ()
    return Responses(response, shown, labels, apart if several else (), found)


def _rehearsed(
    parts: Sequence[Part], pairs: Sequence[Pair], later: Sequence[float], seen: Sequence[Frf], best: Candidate,
    band: tuple[float, float], ask: Ask,
) -> tuple[Frf, tuple[Frf, ...]]:  # fmt: skip
    """All parts together and each by itself without what windows do, which a model of them tells; `seen`: with it."""
    response = trusted(seen[0])
    for _ in range(MOST):
        before, models = response, [delayed(best, seconds) for seconds in later]
        left = _left(parts, pairs, models, band, ask)
        response = trusted(without_windows(seen[0], combined(left, later), best))
        if is_settled(before, response):
            break
        best = refitted(response, best)
    if len(parts) == 1:
        return response, (response,)
    own = [nearer(trusted(without_windows(*each)), each[2]) for each in zip(seen[1:], left, models, strict=True)]
    alone = zip(seen[1:], _left(parts, pairs, own, band, ask), own, strict=True)
    return response, tuple(trusted(without_windows(*each)) for each in alone)


def _left(
    parts: Sequence[Part], pairs: Sequence[Pair], models: Sequence[Candidate], band: tuple[float, float], ask: Ask
) -> list[Spectra]:
    """Spectra of what each part's model leaves over of it."""
    answers = [left_over(pairs[part.index], model) for part, model in zip(parts, models, strict=True)]
    return _spectra(parts, pairs, answers, band, ask)


def band_of(pairs: Sequence[Pair], ask: Ask) -> tuple[float, float]:
    """Frequencies that were asked for, and that the sweeps reach [Hz]."""
    return ask.band[0], min([ask.band[1], *(pair.sweep.f1 for pair in pairs if pair.sweep is not None)])


def _parts(names: Sequence[str], pairs: Sequence[Pair]) -> list[Part]:
    return [
        Part(f"{name}{f' at {amplitude:g} mm/s^2' if amplitude else ''}", i, slice(begin, end))
        for i, (name, pair) in enumerate(zip(names, pairs, strict=True))
        for begin, end, amplitude in pair.segments or ((0, len(pair.command), 0.0),)
    ]


def _spectra(
    parts: Sequence[Part], pairs: Sequence[Pair], answers: Sequence[np.ndarray], band: tuple[float, float], ask: Ask
) -> list[Spectra]:
    """Spectra of each part, of what its command was answered by."""
    seconds = window_seconds(min((p.samples.stop - p.samples.start) / pairs[p.index].fs for p in parts))
    averaged = AVERAGING[ask.averaging]
    return [
        averaged(pairs[p.index].command[p.samples], answer[p.samples], pairs[p.index].fs, band, seconds)
        for p, answer in zip(parts, answers, strict=True)
    ]


def fitted(response: Frf, names: Sequence[str]) -> tuple[Candidate, ...]:
    """Shapes fitted, the chosen one first; errors get the files' names."""
    try:
        return candidates(response)
    except ModelError as error:
        raise RecordingError(str(error), file=", ".join(names)) from None


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
