"""`fbf simulate`: G-code in, predicted motion and its errors out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from fbfcli.cli.files import DASH, check_targets, one_stream, rereading, writing
from fbfcli.cli.lookup import find_file, read_printer
from fbfcli.cli.method_options import METHODS, PERCENT
from fbfcli.cli.options import (
    Numbers,
    json_option,
    printer_option,
    quiet_option,
    segments_option,
    spread_option,
    tolerance_option,
    velocity_option,
)
from fbfcli.cli.pictures import Pictures, png_option, report_option
from fbfcli.cli.telling import fraction_bar, named, tell_json
from fbfcli.units import UM_PER_MM

if TYPE_CHECKING:
    from fbfcli.pipeline.settings import Settings
    from fbfcli.pipeline.simulate import Wanted
    from fbfcli.pipeline.simulation import Simulation
    from fbfcli.pipeline.watcher import Watcher
    from fbfcli.printer import Printer

BEFORE_AND_AFTER = ("none", "auto")
AS_WRITTEN = ("as written",)
KLIPPER_SHAPERS = ("zv", "mzv", "ei", "2hump_ei", "3hump_ei")
MOST_RATE, TRAJECTORY_HZ = 10_000, 1000
MOST_MISMATCH = 50.0  # %


class Names(click.ParamType):
    """Some of the given names, with commas between them."""

    name = "names"

    def __init__(self, known: tuple[str, ...]):
        self._known = known

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        names = tuple(dict.fromkeys(name.strip() for name in str(value).split(",")))
        for name in names:
            if name not in self._known:
                self.fail(f"{name!r} is not one of {', '.join(self._known)}.", param, ctx)
        return names


@click.command(no_args_is_help=False)
@click.argument("file", default=DASH, metavar="[FILE]")
@printer_option
@click.option(
    "-m",
    "--methods",
    type=Names(METHODS),
    metavar="NAME,…",
    help="Compare these in one run. [default: none,auto: before and after]",
)
@click.option(
    "--mismatch",
    type=Numbers(MOST_MISMATCH),
    metavar="PERCENT,…",
    help="Also on a machine whose frequencies are off by this in either direction, and its dampings by a half and two.",
)
@click.option(
    "--family", is_flag=True, help="Also on each of the machines that the profile's uncertainty describes or assumes."
)
@click.option(
    "--accel",
    type=Numbers(),
    metavar="MM/S2,…",
    help="Plan with this acceleration instead of the file's; several: print time against error.",
)
@velocity_option
@click.option(
    "--rate",
    type=click.IntRange(TRAJECTORY_HZ, MOST_RATE),
    default=TRAJECTORY_HZ,
    show_default=True,
    metavar="HZ",
    help="Samples a second, in whole thousands.",
)
@click.option(
    "--firmware-shaper",
    "shapers",
    type=Names(KLIPPER_SHAPERS),
    metavar="NAME,…",
    help="Also these, of the file as it is, in the firmware: made for what Klipper's calibration would take.",
)
@click.option("--plant", metavar="NAME|FILE", help="The true machine, if it is not the printer of -p: another profile.")
@spread_option
@tolerance_option
@segments_option
@report_option
@png_option
@click.option(
    "--csv", "csv_to", metavar="FILE", help="Write where the nozzle goes, sample by sample; - is standard output."
)
@json_option
@quiet_option
def simulate(
    file: str,
    printer: str | None,
    methods: tuple[str, ...] | None,
    mismatch: tuple[float, ...] | None,
    family: bool,
    accel: tuple[float, ...] | None,
    velocity: float | None,
    rate: int,
    shapers: tuple[str, ...] | None,
    plant: str | None,
    spread: float | None,
    tolerance: float,
    segments: float | None,
    report: str | None,
    png: str | None,
    csv_to: str | None,
    json_to: str | None,
    quiet: bool,
) -> None:
    """Show where the nozzle of a vibrating printer really goes.

    The file is executed as the firmware would, and the printer's model is driven with it: before and after
    compensation, or method against method. A file that is compensated already is executed as it is written.

    \b
    fbf simulate part.gcode -p synthetic_bed_slinger                    before and after
    fbf simulate part.gcode -p taz6 -m none,mzv,ei,lpfbs,contour        method against method
    fbf simulate part.gcode -p taz6 --mismatch 10%                      if the machine is not as modelled
    fbf simulate part.gcode -p taz6 --accel 1000,3000,10000             print time against error
    fbf simulate part.gcode -p taz6 --report part.html --png part.png   to look at
    fbf simulate -p taz6 --json - part.fbf.gcode | jq .results
    """
    if rate % TRAJECTORY_HZ:
        raise click.UsageError(f"--rate takes whole thousands, as 1000 or 4000: {rate} is not")
    one_stream(csv_to, json_to, report, png)
    check_targets([file], csv_to, json_to, report, png)
    from fbfcli.pipeline.settings import Settings
    from fbfcli.pipeline.simulate import FIRMWARE, Wanted
    from fbfcli.verify.path_csv import PathCsv

    settings = Settings(
        tolerance=tolerance / UM_PER_MM,
        velocity=velocity,
        segments_per_second=segments,
        spread=None if spread is None else spread / PERCENT,
        patch_times=False,
    )
    wanted = Wanted(
        methods=(methods or BEFORE_AND_AFTER) + tuple(FIRMWARE + name for name in shapers or ()),
        accelerations=accel or (None,),
        mismatches=tuple(one / PERCENT for one in mismatch or ()),
        family=family,
        rate=float(rate),
        machine=None if plant is None else read_printer(find_file(plant)),
    )
    profile = find_file(printer)
    machine, pictures = read_printer(profile), Pictures(report, png)
    with ExitStack() as files:
        watchers: list[Watcher] = [*pictures.watchers]
        if csv_to:
            watchers.append(PathCsv(files.enter_context(writing(csv_to)).write))
        with named(file, str(profile) if plant is None else f"{profile} or {plant}"):
            simulation = _simulate(file, machine, settings, wanted, bool(methods or shapers), watchers, quiet)
    pictures.write(file, simulation, machine, wanted.machine or machine, settings)
    if not quiet:
        click.echo(simulation.text(), err=True)
    if json_to:
        tell_json(json_to, simulation.as_dict())


def _simulate(
    file: str,
    machine: Printer,
    settings: Settings,
    wanted: Wanted,
    chosen: bool,
    watchers: Sequence[Watcher],
    quiet: bool,
) -> Simulation:
    """Read the file as often as needed, and simulate it."""
    from dataclasses import replace

    from fbfcli.gcode.scan import chunks
    from fbfcli.gcode.stamp import looked_into
    from fbfcli.pipeline.simulate import simulate as run

    with rereading(file) as (again, size):
        if looked_into(chunks(again()))[0]:
            if chosen or wanted.accelerations != (None,) or settings.velocity is not None:
                raise click.UsageError(
                    f"{file} is compensated already and executed as it is written: no --methods, --accel or --velocity "
                    "(simulate the original file with them)"
                )
            if not quiet:
                click.echo(
                    f"{file}: is compensated already, executed as it is written; errors are against the written path "
                    "(simulate the original to see them against the part)",
                    err=True,
                )
            wanted = replace(wanted, methods=AS_WRITTEN, stamped=True)

        def texts() -> Iterator[bytes]:
            return chunks(again())

        with fraction_bar(file, quiet) as bar:
            return run(
                texts, machine, settings, wanted, lambda done: bar(done / max(size * wanted.passes, 1)), watchers
            )
