"""The numbers of a report as its page reads them: short lists as they are, long ones as base64 of little-endian bytes.

Positions and errors of layers are whole um, those of corners tenths of them.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable

import numpy as np
from scipy.signal import freqz

from fbfcli.plant.frf import Frf, trusted
from fbfcli.plant.model import BA
from fbfcli.units import UM_PER_MM
from fbfcli.verify import palette
from fbfcli.verify.close_ups import CloseUp, Window
from fbfcli.verify.curves import HIGHEST_HZ, Method
from fbfcli.verify.envelope import Envelope
from fbfcli.verify.layer_paths import Layer, Path
from fbfcli.verify.subject import Face, Subject
from fbfcli.verify.traces import Kept

LINES = 300  # of a plant's response
FINE = 1e4  # steps in a mm that corners are told in
FARTHEST = 32_767  # of them, or um, that a nozzle is told to be away
LARGEST = 65_535  # um, that a sample's error is told with

Json = dict[str, object]


def data(kept: Kept, subject: Subject) -> Json:
    """Everything that the page draws."""
    names = list(kept.methods)
    return {
        "methods": names,
        "colours": [palette.METHODS[i % len(palette.METHODS)] for i in range(len(names))],
        "palette": {"desired": palette.DESIRED, "limit": palette.LIMIT, "ink": palette.INK, "grid": palette.GRID,
                    "errors": palette.ERRORS, "steps": palette.ERROR_STEPS},
        "layers": [_layer(layer) for layer in kept.layers],
        "layerCount": kept.thinning.layers,
        "corners": [_corner(corner, subject.features) for corner in kept.corners],
        "errors": _each(kept, lambda method: _envelope(method.error, UM_PER_MM)),
        "moves": _each(kept, lambda method: _sizes(method.moves)),
        "segments": _each(kept, lambda method: _envelope(method.segments)),
        "load": _each(kept, lambda method: _sizes(method.load, 100.0)),
        "motors": next((method.motors for method in kept.methods.values() if method.motors), ()),
        "asked": _each(kept, lambda method: [_measured(each) for each in method.asked]),
        "reached": _each(kept, lambda method: [_measured(each) for each in method.reached]),
        "plants": [_plant(ba, subject.dt) for ba in subject.plants or ()],
        "ceilings": {"velocity": _numbers(np.array(subject.ceilings.velocity)),
                     "acceleration": _numbers(np.array(subject.ceilings.acceleration)),
                     "segments": _numbers(np.array([subject.ceilings.segments_per_second]))[0]},
        "byLayer": {name: {"rms": _numbers(one.rms, 1), "largest": _numbers(one.largest, 1)}
                    for name, one in (subject.by_layer or {}).items()},
        "byFeature": {name: {"rms": _numbers(one.rms, 1), "largest": _numbers(one.largest, 1)}
                      for name, one in (subject.by_feature or {}).items()},
        "features": subject.features,
        "faces": [_face(face) for face in subject.faces],
    }  # fmt: skip


def _each(kept: Kept, told: Callable[[Method], object]) -> Json:
    return {name: told(method) for name, method in kept.methods.items()}


def _layer(layer: Layer) -> Json:
    return {
        "number": layer.number,
        "z": round(layer.z, 3),
        "desired": _path(layer.desired),
        "nozzle": {name: _path(path) for name, path in layer.nozzle.items()},
    }


def _path(path: Path) -> Json:
    um = np.rint(UM_PER_MM * path.x)
    return {
        "x": _packed(um[:, 0], "<i4"),
        "y": _packed(um[:, 1], "<i4"),
        "error": _packed(np.minimum(np.rint(UM_PER_MM * path.error), LARGEST), "<u2"),
        "line": _packed(path.line + 1, "<i4"),
        "new": _packed(np.flatnonzero(path.new), "<i4"),
    }


def _packed(x: np.ndarray, kind: str) -> str:
    return b64encode(x.astype(kind).tobytes()).decode()


def _corner(corner: CloseUp, features: tuple[str, ...]) -> Json:
    return {
        "method": corner.method,
        "error": round(UM_PER_MM * corner.error, 1),
        "at": [round(v, 4) for v in corner.at],
        "time": round(corner.time, 3),
        "line": corner.line + 1,
        "layer": corner.layer,
        "feature": features[corner.feature] if corner.feature < len(features) else "",
        "windows": {name: _window(window, corner.at) for name, window in corner.windows.items()},
    }


def _window(window: Window, at: tuple[float, float]) -> Json:
    off = np.clip(np.rint(UM_PER_MM * (window.nozzle - window.desired)), -FARTHEST, FARTHEST)
    error = np.clip(np.rint(FINE * window.error), -FARTHEST, FARTHEST)
    return {
        "along": _packed(np.rint(UM_PER_MM * along(window, at)), "<i4"),
        "desired": [_packed(np.rint(FINE * column), "<i4") for column in window.desired.T],
        "off": [_packed(column, "<i2") for column in off.T],
        "error": _packed(error, "<i2"),
    }


def along(window: Window, at: tuple[float, float]) -> np.ndarray:
    """Place of each sample along the desired path, counted from a point of it, shape (n,) [mm]."""
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(window.desired, axis=0).T))])
    return travelled - travelled[np.argmin(np.hypot(*(window.desired - np.array(at)).T))]


def _face(face: Face) -> Json:
    """Profiles, and the slopes that light from the side shows as bright and dark [um/mm]."""
    return {
        "name": face.name,
        "along": {name: _numbers(along, 2) for name, along in face.along.items()},
        "off": {name: _numbers(off, 1) for name, off in face.off.items()},
        "slope": {name: _numbers(np.gradient(off, face.along[name]), 1) for name, off in face.off.items()},
    }


def _envelope(envelope: Envelope | None, scale: float = 1.0) -> Json | None:
    """Largest and RMS of a single curve that is never negative."""
    if envelope is None:
        return None
    return {
        "width": envelope.width,
        "begin": _numbers(envelope.begin, 2),
        "high": _numbers(scale * envelope.high[:, 0], 1),
        "rms": _numbers(scale * envelope.rms[:, 0], 1),
    }


def _sizes(envelope: Envelope | None, scale: float = 1.0) -> Json | None:
    """Largest size of several curves."""
    if envelope is None:
        return None
    sizes = scale * np.maximum(envelope.high, -envelope.low)
    return {"begin": _numbers(envelope.begin, 2), "size": [_numbers(one, 1) for one in sizes.T]}


def _measured(found: Frf | None) -> Json | None:
    if found is None:
        return None
    lines = trusted(found)
    return _response(lines.frequency, lines.H)


def _plant(ba: BA, dt: float) -> Json:
    f = np.geomspace(1.0, HIGHEST_HZ, LINES)
    return _response(f, freqz(*ba, worN=2 * np.pi * f * dt)[1])


def _response(f: np.ndarray, H: np.ndarray) -> Json:
    return {
        "frequency": _numbers(f, 3),
        "magnitude": _numbers(np.abs(H), 4),
        "phase": _numbers(np.degrees(np.unwrap(np.angle(H))), 2),
    }


def _numbers(x: np.ndarray, decimals: int = 6) -> list[float | None]:
    """Rounded; None for what is not finite, which the page leaves out."""
    return [
        round(v, decimals) if finite else None for v, finite in zip(x.tolist(), np.isfinite(x).tolist(), strict=True)
    ]
