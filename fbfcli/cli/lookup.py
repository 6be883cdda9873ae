"""Where a printer profile is found: a file, a bundled name, the environment, the user's own."""

from __future__ import annotations

import os
from difflib import get_close_matches
from pathlib import Path

import fbfcli
from fbfcli.errors import ProfileError
from fbfcli.printer import Printer
from fbfcli.printer_toml import parse_printer

VARIABLE = "FBF_PRINTER"


def bundled_files() -> dict[str, Path]:
    """Profiles that come with fbf, by name."""
    package = Path(fbfcli.__file__).parent
    # beside the package in a checkout, inside it when installed
    folder = next((f for f in (package / "configs", package.parent / "configs") if f.is_dir()), package)
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def bundled() -> dict[str, Printer]:
    """Printers that come with fbf, by the name that `-p` takes."""
    return {name: read_printer(path) for name, path in bundled_files().items()}


def own_file() -> Path:
    """The user's own printer, whether it exists or not."""
    return Path(os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")) / "fbf" / "printer.toml"


def find_printer(value: str | None) -> Printer:
    """The printer that `-p NAME|FILE` names; else that of FBF_PRINTER; else the user's own.

    Raises ProfileError, also where there is none, with how to get one.
    """
    return read_printer(find_file(value))


def find_file(value: str | None) -> Path:
    """Path of the profile that `find_printer` reads."""
    value = value or os.environ.get(VARIABLE)
    if not value:
        if own_file().is_file():
            return own_file()
        raise ProfileError(
            "no printer: give one with -p NAME or -p FILE (`fbf printers` lists names), "
            f"set {VARIABLE}, or write {own_file()}"
        )
    names = bundled_files()
    if value in names and not Path(value).is_file():
        return names[value]
    if Path(value).exists():  # a pipe will do
        return Path(value)
    if value.endswith(".toml") or os.sep in value:
        raise ProfileError(f"{value}: no such printer profile (`fbf printers` lists the bundled ones)")
    near = get_close_matches(value, names, n=1)
    raise ProfileError(
        f"no printer {value!r}: {f'did you mean {near[0]}? ' if near else ''}"
        f"Bundled are {', '.join(names)}; a profile of your own is named by its file"
    )


def read_printer(path: Path) -> Printer:
    """The printer of one profile; the CSV files it names are looked for beside it."""
    return parse_printer(_text(path), str(path), lambda name: _text(path.parent / name))


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ProfileError(f"{path}: is not text in UTF-8") from None
    except OSError as why:
        raise ProfileError(f"{path}: {why.strerror or why}") from None
