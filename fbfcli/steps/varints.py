"""Integers of varying length: seven bits a byte, lowest first, the top bit set on all but the last (LEB128)."""

from __future__ import annotations

import numpy as np

LONGEST = 9  # bytes: 63 bits


def zigzag(value: np.ndarray) -> np.ndarray:
    """Signed to unsigned, small to small: 0, -1, 1, -2 become 0, 1, 2, 3."""
    return (value << 1) ^ (value >> 63)


def unzigzag(value: np.ndarray) -> np.ndarray:
    """`zigzag` undone."""
    return (value >> 1) ^ -(value & 1)


def packed(value: np.ndarray) -> bytes:
    """Bytes of integers, int64, none negative, shape (n,)."""
    shift = 7 * np.arange(LONGEST)
    groups = value[:, None] >> shift
    kept = groups > 0
    kept[:, 0] = True
    more = np.zeros(kept.shape, dtype=bool)
    more[:, :-1] = kept[:, 1:]
    return ((groups & 0x7F) | (more << 7)).astype(np.uint8)[kept].tobytes()


def unpacked(data: bytes) -> np.ndarray:
    """The integers, int64. Raises ValueError where the last one is not whole."""
    byte = np.frombuffer(data, dtype=np.uint8)
    last = np.flatnonzero(byte < 0x80)
    if len(byte) and (not len(last) or last[-1] != len(byte) - 1):
        raise ValueError("a number is cut off")
    size = np.diff(last, prepend=-1)
    if len(size) and size.max() > LONGEST:
        raise ValueError("a number is too long")
    value = np.zeros(len(last), dtype=np.int64)
    for i in range(int(size.max(initial=0))):
        here = np.flatnonzero(size > i)
        value[here] |= (byte[last[here] - size[here] + 1 + i] & 0x7F).astype(np.int64) << (7 * i)
    return value
