"""The complex frequency response that a command and its measured answer have, and how far it can be trusted.

H1 = Sxy / Sxx          right where the noise is in the response (Bendat & Piersol, Random Data, Sec. 6.1 and 9.1)
H2 = Syy / Syx          right where it is in the command
Hv                      total least squares, noise of equal size in both
gamma^2 = |Sxy|^2 / (Sxx Syy)        coherence: what part of the response's power follows from the command
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from fbfcli.plant.spectra import Spectra, together

EXCITED = 1e-3  # of the command's strongest power per Hz: weaker lines are not excited (a Klipper sweep spans 7e2)
LARGEST_SHIFT_S = 0.02  # between the clocks of two recordings that were aligned one by one
ALIKE = 0.5  # lines of less coherence say nothing of a shift


@dataclass(frozen=True)
class Frf:
    """Acceleration measured per acceleration commanded, which is position per position.

    frequency : ndarray, shape (m,)            [Hz]
    width     : ndarray, shape (m,)            of the band that a line averages over [Hz]
    H         : complex ndarray, shape (m,)
    coherence : ndarray, shape (m,)            0 to 1
    sd        : ndarray, shape (m,)            random error: standard deviation of H's real and of its imaginary part
    count     : ndarray, shape (m,)            independent averages
    power     : ndarray, shape (m,)            of the command, any scale
    amplitude : float                          rms of the command while it moves [mm/s^2]
    drift     : float                          how much the delay may change with frequency, where the command is a
                                               sweep: standard deviation [s/Hz]
    """

    frequency: np.ndarray
    width: np.ndarray
    H: np.ndarray
    coherence: np.ndarray
    sd: np.ndarray
    count: np.ndarray
    power: np.ndarray
    amplitude: float = float("nan")
    drift: float = 0.0

LINES = ("frequency", "width", "H", "coherence", "sd", "count", "power")  # fields with an entry for each line


def h1(s: Spectra) -> np.ndarray:
    """Sxy / Sxx."""
    return s.xy / s.xx


def h2(s: Spectra) -> np.ndarray:
    """Syy / Syx."""
    return s.yy / np.where(s.xy == 0, np.finfo(float).tiny, s.xy.conj())


def hv(s: Spectra) -> np.ndarray:
    """Total least squares: the direction of least power in the matrix of spectra [[Sxx, Sxy], [Syx, Syy]]."""
    apart = s.yy - s.xx
    root = np.sqrt(apart**2 + 4 * np.abs(s.xy) ** 2)
    return (apart + root) / np.where(s.xy == 0, np.finfo(float).tiny, 2 * s.xy.conj())


ESTIMATORS: dict[str, Callable[[Spectra], np.ndarray]] = {"h1": h1, "h2": h2, "hv": hv}


def frf(spectra: Spectra, estimator: str = "h1", amplitude: float = float("nan")) -> Frf:
    """The response at the lines that the command excites."""
    density = spectra.xx / spectra.width
    kept = density > EXCITED * density.max()
    H = ESTIMATORS[estimator](spectra)[kept]
    xx, xy, yy, count = (v[kept] for v in (spectra.xx, spectra.xy, spectra.yy, spectra.count))
    coherence = np.clip(np.abs(xy) ** 2 / (xx * np.maximum(yy, np.finfo(float).tiny)), 1e-12, 1.0)
    sd = random_error(H, coherence, count)
    return Frf(spectra.frequency[kept], spectra.width[kept], H, coherence, sd, count, xx, amplitude)


TABLE_COUNT = 10.0  # averages assumed in a response whose origin does not say
TABLE_ERROR = 0.02  # of |H|, of a response without coherence


def from_table(frequency: np.ndarray, H: np.ndarray, coherence: np.ndarray | None) -> Frf:
    """A response that was measured elsewhere. Where it has no coherence, an error of 2 % is taken for random."""
    m = len(frequency)
    count = np.full(m, TABLE_COUNT)
    gamma2 = np.full(m, 1.0) if coherence is None else np.clip(coherence, 1e-3, 1.0)
    sd = random_error(H, gamma2, count) if coherence is not None else TABLE_ERROR * np.abs(H)
    return Frf(frequency, np.zeros(m), H, gamma2, np.maximum(sd, 1e-6), count, np.ones(m))


AGREEING = 0.5  # coherence, of the median of NEIGHBOURS lines, from which on they are believed
NEIGHBOURS = 7


def trusted(frf: Frf) -> Frf:
    """The lines among coherent ones: a single line that agrees by chance is not believed, nor one without a chance."""
    return at_lines(frf, median_filter(frf.coherence, NEIGHBOURS) > AGREEING)


def at_lines(frf: Frf, kept: np.ndarray) -> Frf:
    """The response at some of its lines; `kept`: ndarray of bool, shape (m,)."""
    return replace(frf, **{name: getattr(frf, name)[kept] for name in LINES})


def random_error(H: np.ndarray, coherence: np.ndarray, count: np.ndarray) -> np.ndarray:
    """|H| sqrt((1 - gamma^2) / (2 n gamma^2)), Bendat & Piersol Eq. 9.81.

    With n - 1 for n, for one average always agrees with itself.
    """
    return np.abs(H) * np.sqrt((1 - coherence) / (2 * np.maximum(count - 1, 0.5) * coherence))


def noise_error(s: Spectra) -> np.ndarray:
    """The same error from the power that a response leaves over: sqrt(S_nn / (2 (n - 1) S_xx)), shape (m,)."""
    return np.asarray(np.sqrt(s.noise / (2 * np.maximum(s.count - 1, 0.5) * s.xx)))


def shifts(recordings: Sequence[Spectra]) -> list[float]:
    """Seconds by which each recording's response comes later than the first's.

    Each was aligned by itself, so their delays differ by a few samples, which would wear an average away.
    """
    return [0.0, *(shift_between(recordings[0], s) for s in recordings[1:])]


def combined(recordings: Sequence[Spectra], later: Sequence[float]) -> Spectra:
    """Recordings of one axis as one, after each is shifted in time to agree with the first; `later`: by `shifts`."""
    return together([shifted(s, seconds) for s, seconds in zip(recordings, later, strict=True)])


def shift_between(first: Spectra, other: Spectra) -> float:
    """Seconds by which `other`'s response comes later: where the sum of conj(H_1) H_2 e^{j w tau} is largest."""
    coherence = np.minimum(*(np.abs(s.xy) ** 2 / (s.xx * s.yy) for s in (first, other)))
    turned = np.where(coherence > ALIKE, first.xy.conj() * other.xy / (first.xx * other.xx), 0)
    tau = np.linspace(-LARGEST_SHIFT_S, LARGEST_SHIFT_S, 4001)
    w = 2 * np.pi * first.frequency
    return float(tau[np.argmax((np.exp(1j * np.outer(tau, w)) @ turned).real)])


def shifted(s: Spectra, seconds: float) -> Spectra:
    """The same, with the response earlier by some seconds."""
    return replace(s, xy=s.xy * np.exp(2j * np.pi * s.frequency * seconds))
