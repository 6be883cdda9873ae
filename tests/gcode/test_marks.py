"""Layers and features, as every slicer tells them."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fbfcli.cli.lookup import bundled
from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.marks import UNKNOWN, Marks
from fbfcli.gcode.scan import scan

# of each file of the corpus: layers, their last Z, some of its features
TOLD = {
    "Duet3D__moai-Big-NO_OVERHANG": ("simplify3d", 161, None, {"outer perimeter", "inner perimeter", "raft", "infill"}),
    "OllisGit__20mm_Calibration_Box": ("number", 42, 10.08, {"WALL-OUTER", "SOLID-FILL", "SKIRT"}),
    "OllisGit__LTAZ6A_20x20x5mm-Cube": ("number", 15, None, {"WALL-OUTER", "SKIN", "FILL"}),
    "kageurufu__cura": ("number", 50, None, {"WALL-OUTER", "WALL-INNER", "SKIRT"}),
    "kageurufu__icesl": ("icesl", 42, None, set()),
    "kageurufu__ideamaker.v1": ("number", 54, None, {"RAFT", "BRIDGE"}),
    "kageurufu__kirimoto": ("kirimoto", 25, None, set()),
    "kageurufu__kisslicer.2.0.6": ("kisslicer", 36, None, {"Perimeter", "Loop", "Solid"}),
    "kageurufu__superslicer.supported": ("change", 32, None, {"External perimeter", "Gap fill", "Support material"}),
    "oernster__MediumSquare_ABS_4m45s": ("change", 1, 0.2, {"Outer wall", "Bottom surface"}),
    "own_prusa_cube20_marlin2": ("change", 99, None, {"External perimeter", "Skirt/Brim"}),
    "prestonbrown__OrcaCube_AD5M": ("change", 150, 30.0, {"Outer wall", "Internal Bridge"}),
    "prusa3d__mini_cube_ascii": ("change", 120, None, {"External perimeter", "Internal infill"}),
    "xyz-tools__vase": ("change", 334, None, {"External perimeter", "Top solid infill"}),
}


def marked(text: bytes, cuts: list[int] | None = None) -> Marks:
    """The marks of a text that comes in chunks of whole lines, cut at these lines."""
    lines = text.splitlines(keepends=True)
    ends = [0, *sorted(cuts or []), len(lines)]
    marks = Marks()
    pieces = [b"".join(lines[a:b]) for a, b in pairwise(ends)]
    assert b"".join(marks.passing(pieces)) == text
    return marks


def test_each_slicer_of_the_corpus(corpus_file):
    marks = marked(corpus_file.read_bytes())
    if corpus_file.stem not in TOLD:
        return
    way, layers, top, features = TOLD[corpus_file.stem]
    assert (marks.way, marks.layers) == (way, layers)
    assert features <= set(marks.features)
    if top is not None:
        assert marks.z(layers - 1) == pytest.approx(top, abs=0.01)


@pytest.mark.parametrize("name, way, layers", [("star", "change", 30), ("ringing_tower_cura", "number", 30)])
def test_the_samples(root, name, way, layers):
    marks = marked((root / "sample_gcode" / f"{name}.gcode").read_bytes())
    assert (marks.way, marks.layers) == (way, layers)


@pytest.mark.parametrize(
    "comment, z",
    [
        ("LAYER_CHANGE\n;Z:{z:.1f}", 0.6),
        (" CHANGE_LAYER\n; Z_HEIGHT: {z:.1f}\n; LAYER_HEIGHT: 0.2", 0.6),
        ("LAYER:{n}", np.nan),
        (" layer {n}, Z = {z:.3f}", 0.6),
        (" BEGIN_LAYER_OBJECT z={z:.2f} z_thickness=0.20", 0.6),
        ("; --- layer {n} (0.2 @ {z:.2f}) ---", 0.6),
        (" <layer>", np.nan),
        (" move to next layer ({n})", np.nan),
        ("BEFORE_LAYER_CHANGE\n;{z}\n;AFTER_LAYER_CHANGE\n;{z}", np.nan),
    ],
)
def test_a_layer_is_marked_in_many_ways(comment, z):
    text = "G28\n" + "".join(f";{comment.format(n=n, z=0.2 * n)}\nG1 X{n} E{n}\n" for n in (1, 2, 3))
    marks = marked(text.encode())
    assert marks.layers == 3
    moves = np.flatnonzero(["G1" in line for line in text.splitlines()])
    np.testing.assert_array_equal(marks.layer(moves), [0, 1, 2])
    assert marks.z(2) == pytest.approx(z, nan_ok=True)


@pytest.mark.parametrize(
    "comment, name",
    [
        (";TYPE:External perimeter", "External perimeter"),
        ("; FEATURE: Outer wall\r", "Outer wall"),
        ("; feature outer perimeter", "outer perimeter"),
        ("; outer perimeter", "outer perimeter"),
        ("; 'Perimeter Path', 0.3 [feed mm/s], 7.1 [head mm/s]", "Perimeter"),
        (";segType:Perimeter", "Perimeter"),
        ("G1 X5 Y5 E1 ; infill", "infill"),
    ],
)
def test_a_feature_is_marked_in_many_ways(comment, name):
    marks = marked(f"G1 X1\n{comment}\nG1 X2 E1\n".encode())
    assert marks.features == [UNKNOWN, name]
    np.testing.assert_array_equal(marks.feature(np.arange(3)), [0, 1, 1])


@pytest.mark.parametrize(
    "line",
    [
        "; layer_gcode = ;AFTER_LAYER_CHANGE\\n;[layer_z]",
        "; start_gcode = G28 ;TYPE:Custom",
        "; infill_speed = 80",
        "; total layer number: 150",
        ";LAYER_COUNT:30",
        ";Layer height: 0.2",
        "; layer_height = 0.2",
        "M117 layer 3 / 25",
        "; layer end",
    ],
)
def test_settings_are_no_marks(line):
    marks = marked((line + "\n").encode())
    assert marks.layers == 0 and marks.features == [UNKNOWN]


def test_one_way_of_marking_layers_counts():
    """People put ;LAYER:n into PrusaSlicer's custom G-code."""
    marks = marked(b";LAYER_CHANGE\n;Z:0.2\n;LAYER:0\nG1 X1 E1\n;LAYER_CHANGE\n;Z:0.4\n;LAYER:1\nG1 X1 E1\n")
    assert marks.way == "change" and marks.layers == 2


@given(st.lists(st.integers(1, 30), max_size=5))
def test_chunks_do_not_matter(cuts):
    text = b"".join(b";LAYER:%d\n;TYPE:%s\nG1 X1\n" % (n, b"ABC"[n % 3 : n % 3 + 1]) for n in range(10)) + b";TYPE:end"
    whole, pieces = marked(text), marked(text, cuts)
    lines = np.arange(31)
    np.testing.assert_array_equal(pieces.layer(lines), whole.layer(lines))
    np.testing.assert_array_equal(pieces.feature(lines), whole.feature(lines))
    assert pieces.features == whole.features == [UNKNOWN, "A", "B", "C", "end"]


def test_without_comments_each_new_height_that_prints_is_a_layer(root):
    """The star with its comments taken out has the layers it had."""
    text = (root / "sample_gcode" / "star.gcode").read_bytes()
    bare = b"".join(line.partition(b";")[0].rstrip() + b"\n" for line in text.splitlines())
    told, found = marked(text), marked(bare)
    printer = bundled()["taz6"]
    moves = interpret(scan(bare), initial_state(printer), printer)[0].moves
    prints = (moves.delta[:, 3] > 0) & (moves.delta[:, 0] != 0)
    line, z = moves.line[prints], moves.start[prints, 2]
    for part in np.array_split(np.arange(len(z)), 7):
        found.heights(line[part], z[part])
    assert found.way == "height" and found.layers == told.layers
    np.testing.assert_array_equal(found.layer(line), told.layer(line))
    assert found.z(29) == pytest.approx(told.z(29))


def test_heights_fill_in_what_marks_do_not_say():
    marks = marked(b";LAYER:0\nG1 X1 E1\n;LAYER:1\nG1 X1 E1\n")
    marks.heights(np.array([1, 3]), np.array([0.2, 0.4]))
    assert (marks.layers, marks.z(0), marks.z(1)) == (2, 0.2, 0.4)


def test_a_file_without_anything_says_so():
    marks = marked(b"G1 X1\nG1 X2\n")
    assert (marks.way, marks.layers) == ("", 0)
    np.testing.assert_array_equal(marks.layer(np.arange(2)), 0)
    assert np.isnan(marks.z(0))
