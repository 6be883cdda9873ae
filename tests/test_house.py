"""The house keeps its order: layers, doors, and the size of a file."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "fbfcli"
FLOORS = (  # from the ground up: imports go strictly down, and rooms on one floor do not know each other
    ("digits", "errors", "units"),
    ("printer", "toml_table"),
    ("uncertainty_toml", "motor_toml", "coupling_toml", "profile_text"),
    ("printer_toml",),
    ("motion", "plant", "control", "steps"),
    ("gcode", "verify", "papers"),
    ("pipeline",),
    ("cli",),
)
FLOOR = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}
MOST_LINES = 300
NAMES_THAT_SAY_NOTHING = {"utils", "util", "helpers", "common", "misc", "manager", "core", "base"}
DOORS = {"open", "print", "input", "exit", "quit", "read_text", "write_text", "read_bytes", "write_bytes"}

FILES = sorted(PACKAGE.rglob("*.py"))
TREES = {file: ast.parse(file.read_text()) for file in FILES}


def module_of(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_of(file): file for file in FILES}


def room_of(module: str) -> str:
    """motion, of fbfcli.motion.moves; nothing, of fbfcli itself, which holds the version and may be known to all."""
    return [*module.split("."), ""][1]


def imports(file: Path) -> set[str]:
    """Every module that a file imports, at its top or inside a function."""
    found = set()
    for node in ast.walk(TREES[file]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: imports are written in full"
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (inner & MODULES.keys()) or {str(node.module)}
    return found


def house_imports(file: Path) -> set[str]:
    return {name for name in imports(file) if name.split(".")[0] == "fbfcli"}


each_file = pytest.mark.parametrize("file", FILES, ids=module_of)


@each_file
def test_imports_go_strictly_down(file):
    room = room_of(module_of(file))
    if not room:
        assert not house_imports(file)
        return
    for name in house_imports(file):
        other = room_of(name)
        assert not other or other == room or FLOOR[other] < FLOOR[room], f"{room} imports {name}"


@each_file
def test_control_gets_arrays_only(file):
    if room_of(module_of(file)) == "control":
        assert {room_of(name) for name in house_imports(file)} <= {"control", "errors", "units"}


@each_file
def test_only_cli_has_doors(file):
    if room_of(module_of(file)) == "cli":
        return
    assert not {name for name in imports(file) if name.split(".")[0] in ("click", "sys", "subprocess", "shutil")}
    for node in ast.walk(TREES[file]):
        if isinstance(node, ast.Call):
            called = getattr(node.func, "id", getattr(node.func, "attr", ""))
            assert called not in DOORS, f"line {node.lineno} calls {called}"


@each_file
def test_only_interpret_imports_pygcode(file):
    if module_of(file) != "fbfcli.gcode.interpret":
        assert not any(name.split(".")[0] == "pygcode" for name in imports(file))


@each_file
def test_a_file_is_short_and_says_what_it_is(file):
    assert len(file.read_text().splitlines()) <= MOST_LINES
    assert ast.get_docstring(TREES[file])
    assert not NAMES_THAT_SAY_NOTHING & set(module_of(file).split("."))


@each_file
def test_nouns_are_frozen(file):
    for node in ast.walk(TREES[file]):
        if isinstance(node, ast.ClassDef):
            for mark in node.decorator_list:
                if "dataclass" in ast.unparse(mark):
                    assert "frozen=True" in ast.unparse(mark), f"{node.name} is not frozen"


def test_every_room_has_a_floor():
    assert {room_of(module) for module in MODULES} - {""} <= FLOOR.keys()


def test_no_import_cycles():
    waiting = {module: house_imports(file) & MODULES.keys() - {module} for module, file in MODULES.items()}
    while ready := {module for module, needs in waiting.items() if not needs}:
        waiting = {module: needs - ready for module, needs in waiting.items() if module not in ready}
    assert not waiting, f"cycle among {sorted(waiting)}"


def test_every_package_is_installed():
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    folders = {module_of(file) for file in FILES if file.name == "__init__.py"}
    assert set(packages) == folders | {"fbfcli.configs"}
    assert {file.parent for file in FILES} == {MODULES[folder].parent for folder in folders}
