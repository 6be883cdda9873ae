"""What windows make of a response: a model is measured as the machine was, and what that does to it is taken out.

A sweep passes a frequency in less time than the machine takes to settle, windows cut its answer off, lines average over
their width, and a command that grows through a line moves its centre. None of it is noise: it is the same for a model
that is put through the same command, windows and lines, and there the answer is known. So spectra are taken of what the
model leaves over of the measurement, y - M u, and H = M + S_ur / S_uu: exact where the model is, and what the model
does not explain is as it was measured. What is left incoherent is noise; before, a narrow peak within a line was, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from fbfcli.plant.alignment import Pair
from fbfcli.plant.candidate import Candidate
from fbfcli.plant.fit import lines_within, neighbours_mean
from fbfcli.plant.frf import Frf, h1, noise_error
from fbfcli.plant.shape import measured_response
from fbfcli.plant.spectra import TINY, Spectra

RINGS_S = 8.0  # that a transform leaves a model to come to rest, lest its end ring into its beginning
SETTLED = 0.1  # standard deviations by which a line may still move when nothing more is taken out
SURE = 0.01  # of |H|: random error up to which a line is shown by itself; five times it is 5 %
NOISE = 6.0  # squared random errors: noise leaves over 2, friction on a measured bed slinger 10
AVERAGED = range(3, 71, 2)  # lines that are averaged until it is reached; half as many at the ends of the band
ALIKE = 1.6  # neighbouring lines share bins of their windows: their errors correlate by 0.3
MOST = 6  # rehearsals; each leaves some tenth of what the one before left


def left_over(pair: Pair, candidate: Candidate) -> np.ndarray:
    """Measured less what the model, and what is fitted beside it, answers to the same command, shape (n,)."""
    n = len(pair.command)
    size = next_fast_len(n + int(RINGS_S * pair.fs), real=True)
    M, _ = measured_response(candidate.shape, candidate.theta, 2j * np.pi * rfftfreq(size, 1 / pair.fs))
    return np.asarray(pair.measured - irfft(rfft(pair.command, size) * M, size)[:n])


def delayed(candidate: Candidate, seconds: float) -> Candidate:
    """The same model, of a recording that was aligned so much later."""
    return replace(candidate, theta=candidate.theta + seconds * np.eye(1, candidate.shape.size, 1)[0])


def without_windows(measured: Frf, left: Spectra, candidate: Candidate) -> Frf:
    """The response at the centre of each line, of width 0.

    measured : as the windows show it
    left     : spectra of command and `left_over`, at least at the same lines
    """
    at = np.searchsorted(left.frequency, measured.frequency)
    M, _ = measured_response(candidate.shape, candidate.theta, 2j * np.pi * measured.frequency)
    return replace(measured, H=M + h1(left)[at], sd=noise_error(left)[at], width=np.zeros_like(measured.width))


def is_settled(before: Frf, after: Frf) -> bool:
    """Whether another rehearsal would change nothing that matters."""
    return bool(np.all(np.abs(after.H - before.H) < SETTLED * after.sd))


def steadied(response: Frf, candidate: Candidate) -> Frf:
    """The response as it is shown: what the model leaves over is averaged over neighbours where it is mostly noise.

    A sweep gives a line two averages, and random errors of some per cent where the command or the machine is faint. The
    model carries what is narrow, so the rest can be averaged without blunting a peak: prewhitening (Blackman & Tukey
    1958). As few lines as make the random error SURE; lines that are as sure by themselves stay as measured. Where the
    model leaves over more than noise, nothing is averaged: it would hide what friction and backlash do. Two averages
    say little of a line's own random error, its neighbours' do.
    """
    M, _ = measured_response(candidate.shape, candidate.theta, 2j * np.pi * response.frequency)
    known = 1 / np.maximum(neighbours_mean(response.sd**2), TINY)
    if np.mean(np.abs(response.H - M) ** 2 * known) > NOISE:
        return response
    H, sd = response.H.copy(), np.maximum(response.sd, np.sqrt(1 / known))
    for count in AVERAGED:
        unsure = sd > SURE * np.abs(M)
        total = neighbours_mean(known, count)
        mean = neighbours_mean(known * (response.H - M), count) / total
        H[unsure] = (M + mean)[unsure]
        sd[unsure] = np.sqrt(ALIKE / (total * lines_within(len(M), count)))[unsure]
    return replace(response, H=H, sd=sd)
