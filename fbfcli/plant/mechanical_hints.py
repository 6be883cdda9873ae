"""Signs of something mechanically wrong, or measured wrong, in what was identified: sentences for people."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fbfcli.plant.frf import Frf
from fbfcli.plant.intervals import ModeEstimate

LOW_COHERENCE, MUCH = 0.8, 0.2  # coherence below the first in more than the second of the lines
CLOSE = 1.2  # ratio of two frequencies that are near each other
SHARE = 0.15  # of the strongest peak, that makes another one worth a word
OFF_AXIS = 0.35  # of the moved axis' peak
DAMPED = 0.25
SCALE = 0.1  # of the sensor's gain
MOVED = 0.03  # of a frequency, between amplitudes or runs


def hints_of_response(frf: Frf, off_axis: Sequence[tuple[str, Frf]], gain: float) -> tuple[str, ...]:
    """What the response itself shows; `off_axis`: responses of the other columns to the same command."""
    told = []
    low = frf.coherence < LOW_COHERENCE
    if low.mean() > MUCH:
        told.append(f"coherence is below {LOW_COHERENCE:g} in {100 * low.mean():.0f} % of the lines, mostly around "
                    f"{np.median(frf.frequency[low]):.0f} Hz: loose parts, backlash, friction or too gentle a "
                    "test")  # fmt: skip
    peak = float(np.abs(frf.H).max())
    for name, other in off_axis:
        at = int(np.argmax(np.abs(other.H)))
        if len(other.H) and np.abs(other.H[at]) > OFF_AXIS * peak:
            told.append(f"{name} moves too: {100 * abs(other.H[at]) / peak:.0f} % of the peak at "
                        f"{other.frequency[at]:.0f} Hz: a twisting frame, a racked gantry, or a sensor that is "
                        "tilted")  # fmt: skip
    if abs(gain - 1) > SCALE:
        told.append(f"the sensor reads {gain:.2f} of the commanded acceleration where the machine is rigid: check its "
                    "mounting, the test's acceleration and the unit")  # fmt: skip
    return tuple(told)


def hints_of_modes(modes: Sequence[ModeEstimate]) -> tuple[str, ...]:
    """What the modes say."""
    told = []
    heights = [abs(m.gain.value) / m.damping.value for m in modes]
    loud = [m for m, height in zip(modes, heights, strict=True) if height > SHARE * max(heights)]
    loud.sort(key=lambda m: m.frequency.value)
    for one, next_one in pairwise(loud):
        if next_one.frequency.value < CLOSE * one.frequency.value:
            told.append(f"two peaks close together, {one.frequency.value:.1f} and {next_one.frequency.value:.1f} Hz: "
                        "belts of unequal tension, or the frame swinging with the axis")  # fmt: skip
    if modes and modes[0].damping.value > DAMPED:
        told.append(f"damping {modes[0].damping.value:.2f} is much: friction, or a part that slips")
    return tuple(told)


def hints_of_groups(labels: Sequence[str], frequencies: Sequence[float]) -> tuple[str, ...]:
    """What runs or amplitudes apart say."""
    if len(frequencies) < 2 or max(frequencies) < (1 + MOVED) * min(frequencies):
        return ()
    each = ", ".join(f"{label}: {f:.1f} Hz" for label, f in zip(labels, frequencies, strict=True))
    return (f"the strongest mode moves between recordings ({each}): backlash or friction, or another position",)
