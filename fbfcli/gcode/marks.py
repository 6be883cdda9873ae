"""Layers and feature types of a file, as its slicer marks them in comments.

Who writes what: PrusaSlicer, SuperSlicer, OrcaSlicer `;LAYER_CHANGE`, `;Z:0.2`, `;TYPE:Outer wall`; Bambu Studio
`; CHANGE_LAYER`, `; Z_HEIGHT: 0.2`, `; FEATURE: Outer wall`; Cura, ideaMaker `;LAYER:0`, `;TYPE:WALL-OUTER`; Simplify3D
`; layer 1, Z = 0.2`, `; feature outer perimeter` (version 4.0: `; outer perimeter`); KISSlicer
`; BEGIN_LAYER_OBJECT z=0.2`, `; 'Perimeter Path', ...`; Kiri:Moto `;; --- layer 0 (0.25 @ 0.25) ---`; IceSL
`; <layer>`; Slic3r `; move to next layer (0)`; CraftWare `;segType:Perimeter`; FlashPrint `;layer:0.2`,
`;structure:shell-outer`.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterable, Iterator

import numpy as np

UNKNOWN = "unknown"  # before the first mark, and where a file has none
LEAST_LAYER = 0.04  # mm: no printer's layers are thinner; a smaller step of Z is part of a layer (vase mode)

_SIMPLIFY3D = (  # features that version 4.0 names alone on a line
    rb"(?:outer|inner) perimeter|solid layer|infill|skirt|brim|raft|support|dense support|bridge|gap fill|prime pillar|"
    rb"ooze shield|(?:internal |external )?single extrusion"
)
_LAYERS = {  # a way to mark a layer, and the words behind the semicolon
    "change": rb"LAYER_CHANGE",
    "bambu": rb"CHANGE_LAYER",
    "before": rb"BEFORE_LAYER_CHANGE",
    "number": rb"LAYER ?: ?-?[0-9.]+",
    "simplify3d": rb"layer [0-9]+, Z ?= ?-?[0-9.]+",
    "kisslicer": rb"BEGIN_LAYER_OBJECT z=-?[0-9.]+[^\r\n]*",
    "kirimoto": rb"--- layer [0-9]+ \([0-9.]+ @ -?[0-9.]+\) ---",
    "icesl": rb"<layer>",
    "slic3r": rb"move to next layer \([0-9]+\)",
}
_MARK = re.compile(
    rb";+[ \t]*(?i:"
    + rb"|".join(b"(?P<" + way.encode() + b">" + words + b")" for way, words in _LAYERS.items())
    + rb"|(?:Z|Z_HEIGHT) ?: ?(?P<z>-?[0-9]*\.?[0-9]+)"
    + rb"|(?:TYPE|FEATURE|segType|structure) ?:[ \t]*(?P<named>[^\r\n]+?)"
    + rb"|feature (?P<feature>[^\r\n]+?)"
    + rb"|'(?P<path>[^'\r\n]+) Path'[^\r\n]*"
    + rb"|(?P<alone>" + _SIMPLIFY3D + rb")"
    + rb")[ \t]*\r?$",
    re.MULTILINE,
)  # fmt: skip
_HEIGHT = re.compile(rb"(?:\bz ?= ?|@ )(-?[0-9]*\.?[0-9]+)", re.IGNORECASE)  # within a layer's mark


class Marks:
    """Layers and features of one file, collected while its text streams past; memory grows with the marks alone.

    features : names as the file writes them, in order of appearance; index 0 is UNKNOWN
    way      : how the file marks its layers: a key of the table above, "height" where only its Z tells them, "" so far
               nothing does
    """

    def __init__(self) -> None:
        self.features = [UNKNOWN]
        self.way = ""
        self._number = {UNKNOWN: 0}
        self._layer_line, self._z = array("q"), array("d")
        self._feature_line, self._feature = array("q"), array("q")
        self._count = 0  # lines

    def passing(self, chunks: Iterable[bytes]) -> Iterator[bytes]:
        """The chunks (whole lines), unchanged; what they mark is known when they have been given out."""
        for text in chunks:
            self._read(text)
            yield text

    def heights(self, line: np.ndarray, z: np.ndarray) -> None:
        """Told of extruding motion in order: its lines (n,), its Z (n,) [mm].

        A file without marks gets its layers here, one for each new height; of one with marks, a layer's Z where no mark
        says it.
        """
        if not len(line):
            return
        if self.way in ("", "height"):
            self._by_height(line, z)
            return
        layer = self.layer(line)
        first = np.flatnonzero(np.diff(layer, prepend=-1))
        for k, at in zip(layer[first].tolist(), z[first].tolist(), strict=True):
            if np.isnan(self._z[k]):
                self._z[k] = at

    def layer(self, line: np.ndarray) -> np.ndarray:
        """Layer of each line (n,), both counted from 0; what comes before the first layer counts as part of it."""
        begin = np.array(self._layer_line)
        return np.maximum(np.searchsorted(begin, line, side="right") - 1, 0)

    def feature(self, line: np.ndarray) -> np.ndarray:
        """What each line (n,) prints: index into `features`."""
        begin, feature = np.array(self._feature_line), np.array([0, *self._feature])
        return feature[np.searchsorted(begin, line, side="right")]

    def z(self, layer: int) -> float:
        """Height of a layer [mm]; nan where it is not known."""
        return self._z[layer] if layer < len(self._z) else np.nan

    @property
    def layers(self) -> int:
        """Layers so far; 0 where nothing tells them."""
        return len(self._z)

    def _read(self, text: bytes) -> None:
        """Take the marks of a chunk."""
        found = [mark for mark in _MARK.finditer(text) if _is_comment(text, mark.start())]
        newline = np.flatnonzero(np.frombuffer(text, np.uint8) == ord("\n"))
        lines = np.searchsorted(newline, [mark.start() for mark in found]) + self._count
        for mark, line in zip(found, lines.tolist(), strict=True):
            self._take(mark, line)
        self._count += len(newline) + bool(text and not text.endswith(b"\n"))

    def _take(self, mark: re.Match[bytes], line: int) -> None:
        kind = str(mark.lastgroup)
        if kind == "z":
            if len(self._z):
                self._z[-1] = float(mark["z"])
        elif kind in _LAYERS:
            z = _HEIGHT.search(mark[0])
            self._begin_layer(kind, line, float(z[1]) if z else np.nan)
        else:
            self._begin_feature(mark[kind].decode("utf-8", "replace"), line)

    def _begin_layer(self, way: str, line: int, z: float) -> None:
        """A layer begins; only the first way that a file has counts."""
        if not self.way:
            self.way = way
        elif self.way == "height":
            self._layer_line, self._z, self.way = array("q"), array("d"), way
        same_again = way == "kisslicer" and len(self._z) and self._z[-1] == z  # one mark for each object
        if way == self.way and not same_again:
            self._layer_line.append(line)
            self._z.append(z)

    def _begin_feature(self, name: str, line: int) -> None:
        number = self._number.setdefault(name, len(self.features))
        if number == len(self.features):
            self.features.append(name)
        if not len(self._feature) or self._feature[-1] != number:
            self._feature_line.append(line)
            self._feature.append(number)

    def _by_height(self, line: np.ndarray, z: np.ndarray) -> None:
        self.way = "height"
        k = 0
        while k < len(z):
            if not len(self._z) or abs(z[k] - self._z[-1]) > LEAST_LAYER:
                self._layer_line.append(int(line[k]))
                self._z.append(float(z[k]))
            differs = np.abs(z[k:] - self._z[-1]) > LEAST_LAYER
            k = k + int(differs.argmax()) if differs.any() else len(z)


def _is_comment(text: bytes, at: int) -> bool:
    """No comment began earlier on the line (slicers' settings, at the end of a file, quote marks)."""
    return text.find(b";", text.rfind(b"\n", 0, at) + 1, at) < 0
