"""Where a command begins in a measurement, and how fast the two clocks run against each other.

The command's time is  t_c = clock t + delay, t being the recording's. Three steps:
1. coarse:  the largest correlation of command and measurement over clock and delay, where the machine is rigid;
2. clock:   the one under which most of what is measured is a linear time-invariant function of the command,
            J = sum_f |S_uy|^2 / (S_uu sqrt(S_yy)). A wrong clock turns what the harmonics, or a second pass or marker,
            say of a frequency against what the sweep says of it. No knowledge of the plant goes in. J stands between
            the explained power, in which a resonance drowns all else, and the coherence, in which noise counts fully;
3. delay:   the largest correlation again. The plant's own delay at low frequencies, 2 zeta / omega_n of each mode, goes
            into it: nothing can tell the two apart here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import get_window

from fbfcli.plant.excitation import Sweep, acceleration

RIGID = (0.5, 15.0)  # Hz: below the modes of a printer, above the drift of a sensor
COARSE_FS = 125.0  # Hz, of the correlation where the machine is rigid
DRIFT = 0.25  # of a period at the top of that band: what one step of the coarse clock may be off at the ends
WINDOW = 8.0  # s, of the spectra in J: a hundred times what a machine's response lags, lest J reward following it
WINDOWS = 3  # at least, in one recording
# of J: top of the band [Hz], width to each side in steps of the search before, steps to each side
SEARCHES = ((30.0, 20.0, 36), (80.0, 1.0, 8), (200.0, 0.5, 8))
NEIGHBOURS = 4  # on each side of a largest value, through which a parabola is laid
FINE_DELAY = 2e-5  # s, steps of the last search
LOWEST = 1.0  # Hz: below, J would see the drift of the sensor
HEARD = 1e-6  # of the command's largest power: where it has less it says nothing
TOP = 250.0  # Hz: nothing above is looked at


@dataclass(frozen=True)
class Alignment:
    """t_c = clock t + delay; correlation (with sign) and gain where the machine is rigid."""

    clock: float
    delay: float
    correlation: float
    gain: float


@dataclass(frozen=True)
class Track:
    """One uniformly sampled measurement: rate [Hz], values (n,) with mean removed, of time k / fs."""

    fs: float
    y: np.ndarray

    @property
    def t(self) -> np.ndarray:
        return np.arange(len(self.y)) / self.fs


@dataclass(frozen=True)
class Coarse:
    """Where the correlation is largest; `step`: between the clocks that were tried."""

    correlation: float
    clock: float
    delay: float
    step: float


def coarse(track: Track, sweep: Sweep, span: float) -> Coarse:
    """The first step, for a whole measurement; `span`: how far the clock may be off, as a part of it."""
    slow = decimated(track, COARSE_FS)
    step = DRIFT / (RIGID[1] * 0.5 * min(sweep.duration, track.t[-1]))
    clocks = 1.0 + step * np.arange(-np.ceil(span / step), np.ceil(span / step) + 1)
    tried = [(abs(found[1]), clock, found[0]) for clock in clocks for found in [_correlated(slow, sweep, clock)]]
    return Coarse(*max(tried), step)


def refined(track: Track, sweep: Sweep, start: Coarse) -> Alignment:
    """The second and third step."""
    fast = decimated(track, 2.5 * TOP)
    clock, delay = _clock(fast, sweep, start.clock, start.delay, start.step)
    return _delayed(fast, sweep, clock, delay)


def decimated(track: Track, fs: float) -> Track:
    """At `fs` or less, nothing above four tenths of that left."""
    n = len(track.y)
    spectrum = rfft(track.y, next_fast_len(n + int(track.fs)))
    m = int(np.ceil((2 * len(spectrum) - 2) * min(1.0, fs / track.fs)))
    m += m % 2
    if fs >= track.fs:
        return track
    f = rfftfreq(m)[: m // 2 + 1]
    kept = spectrum[: m // 2 + 1] * np.clip((0.5 - f) / 0.1, 0.0, 1.0)
    true = track.fs * m / (2 * len(spectrum) - 2)
    return Track(true, irfft(kept, m)[: int(n * true / track.fs)] * (m / (2 * len(spectrum) - 2)))


def _correlated(track: Track, sweep: Sweep, clock: float) -> tuple[float, float]:
    """Delay of the largest correlation with the command under a clock, and that correlation with its sign."""
    count = int(np.ceil(sweep.duration / clock * track.fs)) + 1
    u = acceleration(sweep, clock * np.arange(count) / track.fs, clock / track.fs)
    n = next_fast_len(count + len(track.y))
    f = rfftfreq(n, 1 / track.fs)
    band = (f > RIGID[0]) & (f < RIGID[1])
    U, Y = rfft(u, n) * band, rfft(track.y, n) * band
    r = irfft(Y * U.conj(), n)
    at = int(np.argmax(np.abs(r)))
    size = np.sqrt(np.sum(np.abs(U) ** 2) * np.sum(np.abs(Y) ** 2)) * 2 / n
    shift = at - n if at > n // 2 else at
    return -clock * shift / track.fs, float(r[at] / max(size, 1e-300))


def _clock(track: Track, sweep: Sweep, clock: float, delay: float, step: float) -> tuple[float, float]:
    """The clock that explains most, band by band; where the machine is rigid the alignment holds meanwhile."""
    pivot = _pivot(track, sweep, clock, delay)
    for top, width, count in SEARCHES:
        if 5 * sweep.f1 < top:
            break
        offsets = width * step * np.linspace(-1.0, 1.0, 2 * count + 1)
        explained = [_explained(track, sweep, clock + o, delay - o * pivot, top) for o in offsets]
        best = _top(offsets, np.array(explained))
        clock, delay = clock + best, delay - best * pivot
        step = float(offsets[1] - offsets[0]) * 3
    return clock, delay


def _pivot(track: Track, sweep: Sweep, clock: float, delay: float) -> float:
    """The time around which the rigid part of the measurement lies [s]: its delay is known, whatever the clock."""
    spectrum = rfft(acceleration(sweep, clock * track.t + delay, clock / track.fs))
    f = rfftfreq(len(track.y), 1 / track.fs)
    low = irfft(spectrum * ((f > RIGID[0]) & (f < RIGID[1])), len(track.y)) ** 2
    return float(np.sum(low * track.t) / max(np.sum(low), 1e-300))


def _explained(track: Track, sweep: Sweep, clock: float, delay: float, top: float) -> float:
    """J, up to `top` [Hz]."""
    U = _windows(acceleration(sweep, clock * track.t + delay, clock / track.fs), track.fs, top)
    Y = _windows(track.y, track.fs, top)
    S_uy, S_uu, S_yy = np.sum(U.conj() * Y, axis=0), np.sum(np.abs(U) ** 2, axis=0), np.sum(np.abs(Y) ** 2, axis=0)
    heard = (S_uu > HEARD * S_uu.max()) & (S_yy > 0.0)
    return float(np.sum(np.abs(S_uy[heard]) ** 2 / (S_uu[heard] * np.sqrt(S_yy[heard]))))


def _windows(x: np.ndarray, fs: float, top: float) -> np.ndarray:
    """Spectra of Hann windows that overlap by half, shape (windows, lines from LOWEST to `top`)."""
    size = int(min(WINDOW, len(x) / fs / WINDOWS) * fs)
    parts = np.lib.stride_tricks.sliding_window_view(x, size)[:: size // 2]
    lines = slice(*(int(edge * size / fs) for edge in (LOWEST, min(top, 0.4 * fs))))
    return np.asarray(rfft(parts * get_window("hann", size), axis=1)[:, lines])


def _top(x: np.ndarray, y: np.ndarray) -> float:
    """Place of the maximum of noisy values at even places: of a parabola through those around the largest."""
    i = int(np.argmax(y))
    near = slice(max(i - NEIGHBOURS, 0), i + NEIGHBOURS + 1)
    bend, slope, _ = np.polyfit(x[near] - x[i], y[near], 2)
    place = -0.5 * slope / bend if bend < 0 else 0.0
    return float(np.clip(x[i] + place, x[near][0], x[near][-1]))


def _delayed(track: Track, sweep: Sweep, clock: float, delay: float) -> Alignment:
    """The delay of the largest correlation within a fraction of a period, that correlation, and the gain there.

    Gain: H at 0 Hz. Of one mode Re(1/H) is a line over f^2, so U = (p + q f^2) Y; p by instrumental variables U, f^2 U,
    which the noise in Y does not bias.
    """
    u = acceleration(sweep, clock * track.t + delay, clock / track.fs)
    n = next_fast_len(2 * len(u))
    f = rfftfreq(n, 1 / track.fs)
    band = (f > RIGID[0]) & (f < RIGID[1])
    U, Y = rfft(u, n)[band], rfft(track.y, n)[band]
    cross = Y * U.conj()
    lags = FINE_DELAY * np.arange(-500, 501)
    coarse = lags[::20]
    r = _real_sums(cross, f[band], coarse)
    near = lags[np.abs(lags - coarse[np.argmax(np.abs(r))]) <= 20 * FINE_DELAY]
    r = _real_sums(cross, f[band], near)
    lag = _top(near, np.abs(r))
    best = float(r[np.argmax(np.abs(r))])
    size = float(np.sqrt(np.sum(np.abs(U) ** 2) * np.sum(np.abs(Y) ** 2)))
    x = (f[band] / RIGID[1]) ** 2
    in_phase, power = (cross * np.exp(2j * np.pi * f[band] * lag)).real, np.abs(U) ** 2
    moments = np.array([[np.sum(in_phase * x ** (i + j)) for j in range(2)] for i in range(2)])
    p = float(np.linalg.lstsq(moments, np.array([np.sum(power), np.sum(power * x)]), rcond=None)[0][0])
    return Alignment(clock, delay - clock * lag, best / max(size, 1e-300), 1.0 / p if p else 0.0)


def _real_sums(cross: np.ndarray, f: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Correlation at each lag [s], shape of lags."""
    return np.array([np.sum((cross * np.exp(2j * np.pi * f * lag)).real) for lag in lags])
