"""Trajectory on a uniform grid.

A move is four phases: accelerate, cruise, decelerate, hold until the next one starts. In each, the fraction f of the
move that is done is a parabola of the time tau since the phase began: f = f0 + tau (f1 + tau f2), x = start + f delta.
"""

from __future__ import annotations

import numpy as np

from fbfcli.motion.profile import Profile

EPS_SAMPLE = 1e-9  # of a period: a phase that begins this little after a sample owns it (rounding of k dt)


def sample(start: np.ndarray, delta: np.ndarray, d: np.ndarray, profile: Profile, t0: np.ndarray,
           count: int, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions at times k dt, k = 0 .. count - 1, of n >= 1 moves.

    start, delta : ndarray, shape (n, axes)  where each move begins and how far it goes [mm]
    d            : ndarray, shape (n,)       path length [mm]
    t0           : ndarray, shape (n,)       when each move begins [s]; t0[i + 1] >= t0[i] + duration[i]
    Returns x, shape (count, axes), columns contiguous [mm], and the move of each sample, int32, shape (count,).
    Before t0[0] the position is start[0], after a move it is start + delta exactly.
    """
    begins, f = _phases(d, profile, t0, dt)
    first = np.ceil(begins - EPS_SAMPLE)
    first = np.maximum.accumulate(np.minimum(np.maximum(first, 0.0), count)).astype(np.int64)
    first[0] = 0
    counts = np.diff(first, append=count)
    used = np.flatnonzero(counts)
    counts = counts[used]
    phase = np.repeat(np.arange(len(used)), counts)
    tau = np.arange(count, dtype=float)
    tau -= np.take(begins[used], phase)
    part = np.take(f[2, used], phase)
    part *= tau
    part += np.take(f[1, used], phase)
    part *= tau
    part += np.take(f[0, used], phase)
    part[:max(0, min(count, int(np.ceil(begins[0] - EPS_SAMPLE))))] = 0.0
    move = used >> 2
    x = np.empty((count, start.shape[1]), order="F")
    for axis in range(start.shape[1]):
        column = x[:, axis]
        np.multiply(part, np.take(delta[move, axis], phase), out=column)
        column += np.take(start[move, axis], phase)
    return x, np.take(move.astype(np.int32), phase)


def _phases(d: np.ndarray, profile: Profile, t0: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """When the 4 n phases begin, in periods, shape (4 n,), and their f0, f1, f2, shape (3, 4 n)."""
    n = len(d)
    begins = np.empty((n, 4))
    f = np.zeros((3, n, 4))
    t_accel, t_decel = profile.t_accel, profile.t_decel
    begins[:, 0] = t0
    begins[:, 1] = t0 + t_accel
    begins[:, 2] = begins[:, 1] + profile.t_cruise
    begins[:, 3] = begins[:, 2] + t_decel
    begins *= 1.0 / dt
    per_d = np.divide(dt, d, out=np.zeros(n), where=d > 0.0)
    gain, loss = profile.v_cruise - profile.v_start, profile.v_cruise - profile.v_end
    f[0, :, 1] = (0.5 / dt) * per_d * (profile.v_start + profile.v_cruise) * t_accel
    f[0, :, 2] = 1.0 - (0.5 / dt) * per_d * (profile.v_end + profile.v_cruise) * t_decel
    f[0, :, 3] = 1.0
    f[1, :, 0] = per_d * profile.v_start
    f[1, :, 1] = f[1, :, 2] = per_d * profile.v_cruise
    f[2, :, 0] = (0.5 * dt) * per_d * np.divide(gain, t_accel, out=np.zeros(n), where=t_accel > 0.0)
    f[2, :, 2] = (-0.5 * dt) * per_d * np.divide(loss, t_decel, out=np.zeros(n), where=t_decel > 0.0)
    return begins.ravel(), f.reshape(3, 4 * n)
