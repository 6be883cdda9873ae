"""`fbf printers`: what -p can name, and whether a profile can be used."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import click

from fbfcli.cli.lookup import bundled_files, find_file, own_file, read_printer
from fbfcli.errors import FbfError, ProfileError

DT = 1e-3  # s: the period that models are checked at
MODES_SHOWN = 3  # of each axis, the strongest: a measured response has many that mean little


@dataclass(frozen=True)
class Row:
    """One printer as it is listed. `modes` holds (frequency [Hz], damping) of each compensated axis."""

    name: str
    file: str
    firmware: str
    kinematics: str
    modes: dict[str, list[tuple[float, float]]]
    source: str


@click.group(invoke_without_command=True)
@click.option("--json", "as_json", is_flag=True, help="Write JSON.")
@click.pass_context
def printers(context: click.Context, as_json: bool) -> None:
    """List the printers that -p can name: those that come with fbf, and your own.

    \b
    fbf printers
    fbf printers --json | jq -r '.[].name'
    fbf printers check my_printer.toml
    """
    if context.invoked_subcommand is None:
        files = bundled_files() | ({str(own_file()): own_file()} if own_file().is_file() else {})
        rows, refused = _rows(files)
        click.echo(json.dumps([asdict(row) for row in rows], indent=2) if as_json else _listing(rows))
        if refused:
            raise ProfileError("; ".join(refused))


@printers.command()
@click.argument("profiles", nargs=-1, required=True, metavar="NAME|FILE...")
def check(profiles: tuple[str, ...]) -> None:
    """Check profiles: every key and number, and that each model is stable and follows its command at rest.

    \b
    fbf printers check my_printer.toml
    fbf printers check taz6 hictop_prusa_i3
    """
    rows, refused = _rows({name: find_file(name) for name in profiles})
    for row in rows:
        click.echo(f"{row.name}: good: {row.firmware}, {row.kinematics}; {_modes(row)}")
    if refused:
        raise ProfileError("; ".join(refused))


def _rows(files: dict[str, Path]) -> tuple[list[Row], list[str]]:
    """The printers that can be used, and why the others cannot."""
    rows, refused = [], []
    for name, file in files.items():
        try:
            rows.append(_row(name, file))
        except FbfError as error:
            refused.append(str(error))
    return rows, refused


def _row(name: str, file: Path) -> Row:
    from fbfcli.plant.model import modes, plant_of  # imports numpy and scipy
    from fbfcli.plant.uncertainty import members

    printer = read_printer(file)
    found = {}
    for axis in printer.axes:
        if axis.model is not None:
            try:
                key = "model"
                plant = plant_of(axis.model, DT, axis.name)
                key = "uncertainty"
                if axis.uncertainty is not None:
                    members(axis.model, axis.uncertainty, DT, axis.name)
                for i, place in enumerate(axis.at):
                    key = f"at[{i}].model"
                    plant_of(place.model, DT, axis.name)
            except FbfError as error:
                raise ProfileError(f"{file}: axis.{axis.name.lower()}.{key}: {error}") from None
            found[axis.name.lower()] = sorted((mode.frequency, mode.damping) for mode in modes(plant)[:MODES_SHOWN])
    return Row(name, str(file), printer.firmware, printer.kinematics, found, printer.source)


def _modes(row: Row) -> str:
    """Frequencies of each axis, for people."""
    return (
        ", ".join(
            f"{axis} {' + '.join(f'{frequency:.1f}' for frequency, _ in found) or '-'} Hz"
            for axis, found in row.modes.items()
        )
        or "no model"
    )


def _listing(rows: list[Row]) -> str:
    table = [("name", "firmware", "kinematics", "modes", "source")]
    table += [(row.name, row.firmware, row.kinematics, _modes(row), row.source) for row in rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in table
    )
