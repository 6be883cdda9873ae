"""Steps as a NumPy archive: for each motor `<name>_time` [ns, int64] and `<name>_forward` [bool].

    steps = np.load("part.npz")
    steps["motors"], steps["steps_per_mm"], steps["x_time"] * 1e-9, steps["x_forward"]

An array's length stands in front of it and is known at the end only: until then arrays wait in temporary files.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from fbfcli.errors import FbfError
from fbfcli.steps.stream import Motors, MotorSteps, Piece

CHUNK = 1 << 20
EPOCH = (1980, 1, 1, 0, 0, 0)  # the same stream gives the same bytes


class _Sink:
    """Takes what zipfile writes until it is asked for."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def write(self, data: bytes) -> int:
        self._parts.append(bytes(data))
        return len(data)

    def flush(self) -> None:
        """Nothing waits below."""

    def taken(self) -> bytes:
        """All of it since the last time."""
        data, self._parts = b"".join(self._parts), []
        return data


class NpzWriter:
    """Writes a stream as a NumPy archive; its temporary files are closed with `files`."""

    def __init__(self, motors: Motors, files: ExitStack):
        self._motors = motors
        self._spools = [(_spool(files), _spool(files)) for _ in motors.names]
        self._counts = [0] * len(motors.names)

    def head(self) -> Iterator[bytes]:
        yield b""

    def add(self, piece: Piece) -> Iterator[bytes]:
        """Nothing yet."""
        for i, steps in enumerate(piece.steps.motors):
            time, forward = self._spools[i]
            time.write(steps.time.astype("<i8").tobytes())
            forward.write(steps.forward.tobytes())
            self._counts[i] += len(steps)
        yield b""

    def end(self) -> Iterator[bytes]:
        """The archive."""
        sink = _Sink()
        with zipfile.ZipFile(sink, "w") as archive:  # type: ignore[call-overload]
            about = {"motors": np.array(self._motors.names), "steps_per_mm": np.array(self._motors.steps_per_mm)}
            for name, array in about.items():
                whole = io.BytesIO()
                np.save(whole, array)
                archive.writestr(zipfile.ZipInfo(f"{name}.npy", EPOCH), whole.getvalue())
            for name, count, (time, forward) in zip(self._motors.names, self._counts, self._spools, strict=True):
                for label, spool, dtype in ((f"{name}_time", time, "<i8"), (f"{name}_forward", forward, "|b1")):
                    with archive.open(zipfile.ZipInfo(f"{label}.npy", EPOCH), "w", force_zip64=True) as member:
                        header = {"descr": dtype, "fortran_order": False, "shape": (count,)}
                        np.lib.format.write_array_header_1_0(member, header)
                        spool.seek(0)
                        while data := spool.read(CHUNK):
                            member.write(data)
                            yield sink.taken()
        yield sink.taken()


def _spool(files: ExitStack) -> IO[bytes]:
    return files.enter_context(TemporaryFile())


def read_npz(data: bytes) -> dict[str, MotorSteps]:
    """The steps of each motor. Raises FbfError."""
    try:
        with np.load(io.BytesIO(data)) as arrays:
            names = [str(name) for name in arrays["motors"]]
            return {name: MotorSteps(arrays[f"{name}_time"], arrays[f"{name}_forward"]) for name in names}
    except (ValueError, KeyError, OSError, zipfile.BadZipFile, EOFError) as why:
        raise FbfError(f"not a NumPy archive of steps: {why}") from None
