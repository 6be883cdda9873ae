"""`fbf excite`: a printer in, sweep G-code and the acceleration that it commands out."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import click

from fbfcli.cli.files import DASH, check_targets, saying
from fbfcli.cli.lookup import find_file, read_printer
from fbfcli.cli.options import Number, json_option, printer_option, quiet_option
from fbfcli.cli.telling import named, tell_json


@click.command()
@printer_option
@click.option("--axis", type=click.Choice(["x", "y"]), required=True, help="The axis to shake.")
@click.option("-o", "--output", metavar="FILE", help="Write the G-code here; - is standard output. "
              "[default: sweep_AXIS.gcode]")  # fmt: skip
@click.option("--csv", "csv_to", metavar="FILE", help="Write the commanded acceleration here. "
              "[default: the G-code's name with .csv]")  # fmt: skip
@click.option("--from", "f0", type=Number(1, 200), default=5.0, show_default=True, metavar="HZ", help="Begin at.")
@click.option("--to", "f1", type=Number(2, 400), default=130.0, show_default=True, metavar="HZ", help="End at.")
@click.option("--rate", type=Number(0.1, 50), default=4.0, show_default=True, metavar="HZ/S", help="Rise by.")
@click.option("--accel", "accelerations", type=Number(min=100), multiple=True, metavar="MM/S2",
              help="Amplitude; several times for several sweeps. [default: 2000, 3500 and 5000, as far as the printer "
              "goes]")  # fmt: skip
@json_option
@quiet_option
def excite(
    printer: str | None,
    axis: str,
    output: str | None,
    csv_to: str | None,
    f0: float,
    f1: float,
    rate: float,
    accelerations: tuple[float, ...],
    json_to: str | None,
    quiet: bool,
) -> None:
    """Write a sweep that shows how a printer vibrates.

    Print the file with an accelerometer recording, then give the recording to `fbf identify` with the CSV, which tells
    what the file commands. The machine homes, goes to the middle of its bed and is shaken: watch it.

    \b
    fbf excite -p synthetic_bed_slinger --axis x          writes sweep_x.gcode and sweep_x.csv
    fbf excite -p taz6 --axis y --accel 1500 -o y.gcode   one amplitude
    fbf excite -p taz6 --axis x -o - --csv x.csv > x.gcode
    """
    from fbfcli.pipeline.excite import excite as run

    if f1 < 2 * f0:
        raise click.UsageError(f"--to {f1:g} must be twice --from {f0:g}, or more")
    target = output or f"sweep_{axis}.gcode"
    command = csv_to or (None if target == DASH else str(Path(target).with_suffix(".csv")))
    if [target, command, json_to].count(DASH) > 1:
        raise click.UsageError("only one of -o, --csv and --json can go to standard output")
    profile = find_file(printer)
    check_targets([str(profile)], target, command, json_to)
    with named(str(profile), str(profile)):
        made = run(read_printer(profile), axis, f0, f1, rate, accelerations)
    with saying(target) as say, saying(command) if command else nullcontext() as say_command:
        say(made.gcode.decode())
        if say_command:
            say_command(made.command)
    if not quiet:
        click.echo(made.summary.text(), err=True)
    if json_to:
        tell_json(json_to, made.summary.as_dict())
