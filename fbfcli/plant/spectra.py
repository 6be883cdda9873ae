"""Auto- and cross-spectra of a command and what was measured of it, averaged until their coherence means something.

X, Y : spectra of a window of the command x and the response y      Sxx, Sxy, Syy : their averaged products
A sweep visits each frequency once, for about a second. At all other times that frequency holds noise, and the harmonics
that backlash and friction make of other frequencies. On a measured bed slinger the coherence at 60 Hz is 0.3 over the
whole record and 0.98 over the seconds in which 60 Hz were commanded. So each line averages over its own windows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.signal import get_window

WINDOWS = 15  # in a record, so that a sweep's harmonics stay out of the window ...
SHORTEST_S, LONGEST_S = 2.0, 8.0  # ... that is long enough to resolve a mode: 8 s tell 0.25 Hz apart
HOPS = 4  # in a window: Hann windows shifted by a quarter sum up to a constant
BINS = 2  # of the transform in a line, at least
RELATIVE_WIDTH = 0.01  # of a line: a mode of damping 0.02 is 4 % of its frequency wide
GATE = 0.03  # of a line's strongest window: in weaker ones the command is elsewhere, and coherence means nothing
# Where a sweep enters and leaves a window the response is cut off, which cancels over all windows that hold some of it
FAINT = 1e-4
# Power of Hann windows shifted by 0, 1/4, 1/2, 3/4 correlates by these, that of bins 0, 1, 2 apart by those
OVERLAP = np.array([1.0, 0.435, 0.028])
LEAKAGE = np.array([1.0, 0.444, 0.028])
TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Spectra:
    """Averaged spectra at m lines.

    frequency  : ndarray, shape (m,)           centre of each line, weighted by the command's power [Hz]
    width      : ndarray, shape (m,)           a line averages the response as a band of this width does [Hz]
    xx, xy, yy : ndarrays, shape (m,)          |X|^2, X* Y (complex), |Y|^2
    noise      : ndarray, shape (m,)           of |Y|^2 what no line of one response explains, in proportion to xx
    count      : ndarray, shape (m,)           independent averages in each line
    """

    frequency: np.ndarray
    width: np.ndarray
    xx: np.ndarray
    xy: np.ndarray
    yy: np.ndarray
    noise: np.ndarray
    count: np.ndarray


def short_time(x: np.ndarray, y: np.ndarray, fs: float, band: tuple[float, float], seconds: float = 0.0) -> Spectra:
    """Each line averaged over the windows in which the command holds it: for sweeps.

    x, y    : ndarray, shape (n,)   command and response
    fs      : rate [Hz]
    band    : lowest and highest frequency [Hz]
    seconds : length of the windows, 0: by the record's
    """
    return _averaged(x, y, fs, band, seconds or window_seconds(len(x) / fs), GATE)


def window_seconds(duration: float) -> float:
    """Length of the windows for a record of this length [s]."""
    return float(np.clip(duration / WINDOWS, SHORTEST_S, LONGEST_S))


def welch(x: np.ndarray, y: np.ndarray, fs: float, band: tuple[float, float], seconds: float = 0.0) -> Spectra:
    """Each line averaged over all windows: for commands that hold all frequencies at all times."""
    return _averaged(x, y, fs, band, seconds or SHORTEST_S, 0.0)


AVERAGING = {"short-time": short_time, "welch": welch}


def _averaged(
    x: np.ndarray, y: np.ndarray, fs: float, band: tuple[float, float], seconds: float, gate: float
) -> Spectra:
    size = min(next_fast_len(int(seconds * fs), real=True), len(x))
    f = np.arange(size // 2 + 1) * fs / size
    edges = np.searchsorted(f, _edges(band[0], min(band[1], fs / 2), seconds))
    first = edges[np.append(True, np.diff(edges) > 0)]
    bins_in_line = np.diff(first)

    def lines(bins: np.ndarray) -> np.ndarray:
        return np.add.reduceat(bins[: first[-1]], first[:-1])

    rows = []
    for X, Y in _transforms(x, y, size):
        power = np.abs(X) ** 2
        rows.append((lines(power), lines(X.conj() * Y), lines(np.abs(Y) ** 2), lines(power * f)))
    xx, xy, yy, xf = (np.array(column) for column in zip(*rows, strict=True))
    strongest = xx.max(axis=0)
    heard, faint = xx >= gate * strongest, xx >= min(gate, FAINT) * strongest
    command, answer = (np.maximum((heard * power).sum(axis=0), TINY) for power in (xx, yy))
    agreeing = np.abs((heard * xy).sum(axis=0)) ** 2 / command
    coherence = agreeing / answer
    total, cross = np.maximum((faint * xx).sum(axis=0), TINY), (faint * xy).sum(axis=0)
    return Spectra(
        frequency=np.where(total > TINY, (faint * xf).sum(axis=0) / total, 0.5 * (f[first[:-1]] + f[first[1:] - 1])),
        # a window of T seconds blurs like a band of 2 / T: the mean of w'^2 over that of w^2 is (2 pi / T)^2 / 3
        width=np.hypot(bins_in_line, 2) * fs / size,
        xx=total,
        xy=cross,
        yy=np.abs(cross) ** 2 / (total * np.maximum(coherence, TINY)),  # as coherent as where the command is
        noise=np.maximum(answer - agreeing, 0.0) * total / command,
        count=_independent(heard * xx) * _independent_bins(bins_in_line),
    )


def _transforms(x: np.ndarray, y: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """X, Y of one window after the other; the record is longer by half a window at an end at which it rests.

    An end in the middle of a motion is left to the windows' own slopes: a cliff there leaks into all frequencies.
    """
    window = get_window("hann", size)
    still = max(1, size // 100)
    resting = [not x[:still].any(), not x[-still:].any()] if len(x) > size else [False, False]
    around = [size // 2 * rest for rest in resting]
    x, y = (np.pad(v, around) for v in (x, y - y.mean()))
    for start in range(0, len(x) - size + 1, max(1, size // HOPS)):
        yield rfft(window * x[start : start + size]), rfft(window * y[start : start + size])


def _independent(p: np.ndarray) -> np.ndarray:
    """Independent averages among windows of power p, shape (windows, m): (sum p)^2 / sum p_k p_l rho_kl."""
    overlapping = sum(
        (1 if k == 0 else 2) * rho * (p[: len(p) - k] * p[k:]).sum(axis=0) for k, rho in enumerate(OVERLAP[: len(p)])
    )
    return np.asarray(p.sum(axis=0) ** 2 / np.maximum(overlapping, TINY))


def _independent_bins(n: np.ndarray) -> np.ndarray:
    """The same of n neighbouring bins of equal power."""
    return np.asarray(n**2 / (n * LEAKAGE[0] + 2 * (n - 1) * LEAKAGE[1] + 2 * np.maximum(n - 2, 0) * LEAKAGE[2]))


def _edges(low: float, high: float, seconds: float) -> np.ndarray:
    """Edges of lines [Hz]: BINS apart, then RELATIVE_WIDTH of their frequency; the same at any rate."""
    width = BINS / seconds
    even = np.arange(low, min(high, max(width / RELATIVE_WIDTH, low + width)) + 0.5 * width, width)
    count = max(0, int(np.log(high / even[-1]) / RELATIVE_WIDTH))
    return np.concatenate((even, even[-1] * np.exp(RELATIVE_WIDTH * np.arange(1, count + 1))))


def together(spectra: Sequence[Spectra]) -> Spectra:
    """Several recordings of one thing as one: products add up. They must have the same lines."""
    xx = np.sum([s.xx for s in spectra], axis=0)
    return Spectra(
        frequency=np.sum([s.xx * s.frequency for s in spectra], axis=0) / xx,
        width=spectra[0].width,
        xx=xx,
        xy=np.sum([s.xy for s in spectra], axis=0),
        yy=np.sum([s.yy for s in spectra], axis=0),
        noise=np.sum([s.noise for s in spectra], axis=0),
        count=np.sum([s.count for s in spectra], axis=0),
    )
