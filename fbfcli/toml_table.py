"""One table of a TOML file, taken apart key by key: every refusal names file, key, value and remedy."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from difflib import get_close_matches
from math import inf, isfinite
from typing import Any, NoReturn

from fbfcli.errors import ProfileError

QUOTE = 60  # characters of a refused value worth showing


@dataclass(frozen=True)
class Table:
    """One table and its place.

    file   : name of the file, for messages
    path   : dotted name of the table ("axis.x"), empty for the file itself
    values : what it holds
    """

    file: str
    path: str
    values: dict[str, Any]

    def where(self, key: str) -> str:
        key = key if key.isprintable() else repr(key)  # TOML allows a newline in a quoted key
        return f"{self.path}.{key}" if self.path else key

    def refuse(self, key: str, why: str, remedy: str = "") -> NoReturn:
        """Raise a ProfileError of one line about this key."""
        value = f" = {repr(self.values[key])[:QUOTE]}" if key in self.values else ""
        hint = f" ({remedy})" if remedy else ""
        raise ProfileError(f"{self.file}: {self.where(key)}{value}: {why}{hint}")

    def only(self, *known: str) -> Table:
        """This table, once every key in it is one of `known`; free text under `note` is always welcome."""
        for key in self.values:
            if key not in (*known, "note"):
                near = get_close_matches(key, known, n=1)
                self.refuse(key, "unknown key", f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}")
        if not isinstance(self.values.get("note", ""), str):
            self.refuse("note", "must be text", 'write it in quotes: note = "..."')
        return self

    def need(self, key: str, example: str) -> None:
        if key not in self.values:
            self.refuse(key, "is missing", f"add {example}")

    def table(self, key: str) -> Table:
        """The table of this name; KeyError never: its absence is refused."""
        self.need(key, f"a section [{self.where(key)}]")
        if not isinstance(self.values[key], dict):
            self.refuse(key, "must be a section", f"write [{self.where(key)}]")
        return Table(self.file, self.where(key), self.values[key])

    def text(self, key: str, default: str | None = None) -> str:
        if default is not None and key not in self.values:
            return default
        self.need(key, f'{key} = "..."')
        value = self.values[key]
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            self.refuse(key, "must be one line of text", f'write {key} = "..."')
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        value = self.text(key)
        if value not in choices:
            near = get_close_matches(value.lower(), choices, n=1)
            self.refuse(key, "is not known", f"did you mean {near[0]}?" if near else f"one of {', '.join(choices)}")
        return value

    def number(self, key: str, default: float | None = None, *, above: float = 0.0, least: float = -inf,
               below: float = inf) -> float:
        """A finite number, > above, >= least and < below. `above = -inf` with `least = 0` admits zero."""
        if default is not None and key not in self.values:
            return default
        self.need(key, f"{key} = <number>")
        value = self.finite(key, self.values[key])
        if not value > above:
            self.refuse(key, f"must be greater than {above:g}")
        if not value >= least:
            self.refuse(key, f"must not be less than {least:g}")
        if not value < below:
            self.refuse(key, f"must be less than {below:g}")
        return value

    def numbers(self, key: str, example: str) -> tuple[float, ...]:
        """A list of finite numbers, not empty."""
        self.need(key, example)
        value = self.values[key]
        if not isinstance(value, list) or not value:
            self.refuse(key, "must be a list of numbers", f"write {example}")
        return tuple(self.finite(key, v) for v in value)

    def tables(self, key: str, example: str) -> tuple[Table, ...]:
        """A list of tables, not empty."""
        value = self.values[key]
        if not isinstance(value, list) or not value or not all(isinstance(v, dict) for v in value):
            self.refuse(key, "must be a list of tables", f"write {example}")
        return tuple(Table(self.file, f"{self.where(key)}[{i}]", v) for i, v in enumerate(value))

    def finite(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(key, "must be a number", "numbers are written without quotes")
        if abs(value) > 1e300 or not isfinite(value):  # before float(): an integer of TOML has no largest value
            self.refuse(key, "must be a finite number")
        return float(value)


def parse_toml(text: str, file: str) -> Table:
    """The whole file as a Table. ProfileError where it is not TOML."""
    try:
        return Table(file, "", tomllib.loads(text))
    except (ValueError, RecursionError) as why:  # ValueError: TOMLDecodeError, and integers too long to read
        raise ProfileError(f"{file}: not TOML: {' '.join(str(why).split())}") from None
