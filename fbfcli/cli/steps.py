"""`fbf steps`: G-code in, step pulses out."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fbfcli.cli.files import DASH, check_targets, is_stream, reading, writing
from fbfcli.cli.lookup import find_file, read_printer
from fbfcli.cli.method_options import method_options, settings_of
from fbfcli.cli.options import Number, json_option, printer_option, quiet_option
from fbfcli.cli.telling import named, progress_bar, tell_json

if TYPE_CHECKING:
    from fbfcli.pipeline import Settings
    from fbfcli.pipeline.steps import StepsSummary
    from fbfcli.printer import Driver
    from fbfcli.steps.formats import Writer
    from fbfcli.steps.stream import Motors

ENDINGS = {  # of files, by format; as steps.formats has them, without importing numpy
    "csv": ".csv",
    "npz": ".npz",
    "compact": ".steps",
    "vcd": ".vcd",
    "positions": ".txt",
    "marlin": ".g6",
}
RATED = ("positions", "marlin")
EVENTS = ".events.jsonl"


@click.command(no_args_is_help=False)
@click.argument("file", default=DASH, metavar="[FILE]")
@printer_option
@click.option("-o", "--output", metavar="FILE", help="Write here; - is standard output. [default: beside FILE]")
@click.option(
    "-t",
    "--format",
    "name",
    type=click.Choice(tuple(ENDINGS)),
    help="Of the stream. [default: by the ending of -o, else csv]",
)
@click.option(
    "--rate",
    type=Number(min=1, max=1e7),
    metavar="HZ",
    help="positions: lines per second [1000]; marlin: ticks per second [56000].",
)
@click.option(
    "--events",
    metavar="FILE",
    help="Write the file's other lines with their times here, as JSON lines. [default: OUTPUT.events.jsonl]",
)
@method_options
@json_option
@click.option("-n", "--dry-run", is_flag=True, help="Compute and tell everything, write nothing.")
@quiet_option
def steps(
    file: str,
    printer: str | None,
    output: str | None,
    name: str | None,
    rate: float | None,
    events: str | None,
    json_to: str | None,
    dry_run: bool,
    quiet: bool,
    **how: Any,
) -> None:
    """Turn a print into the step pulses of its motors.

    The motion is planned and compensated as in `fbf compensate`, and becomes a stream of steps instead of G-code, for
    machines that take one, and for a look at what the motors will do. A file that is compensated already is taken as it
    is written. Heaters, fans and other lines go to a file of events beside the stream.

    \b
    fbf steps part.gcode -p synthetic_corexy                        writes part.csv and part.csv.events.jsonl
    fbf steps part.gcode -p taz6 --format vcd -o part.vcd           for GTKWave and PulseView
    fbf steps part.gcode -p taz6 -m none -t positions -o - | halstreamer
    zcat part.gcode.gz | fbf steps -p taz6 -t compact --events part.jsonl > part.steps
    """
    name = name or _by_ending(output)
    if rate is not None and name not in RATED:
        raise click.UsageError(f"--rate is for {' and '.join(RATED)}, not for {name}")
    targets = _targets(file, output, ENDINGS[name], events, json_to, dry_run)
    summary, size = _steps(file, printer, how, name, rate, targets, quiet)
    if not quiet:
        from fbfcli.pipeline.rows import row

        total = sum(motor.steps for motor in summary.motors)
        click.echo(summary.text(), err=True)
        click.echo(row("size", f"{size:,} bytes as {name}, {size / max(total, 1):.2f} per step"), err=True)
    if json_to:
        tell_json(json_to, {"format": name, "bytes": size, **summary.as_dict()})


def _by_ending(output: str | None) -> str:
    """The format that a file's name asks for."""
    ending = Path(output or "").suffix.lower()
    return next((name for name, usual in ENDINGS.items() if usual == ending), "csv")


def _targets(
    file: str, output: str | None, ending: str, events: str | None, json_to: str | None, dry_run: bool
) -> tuple[str | None, str | None]:
    """Where the stream and its events go: a file, standard output, or (None) nowhere."""
    target = output or (DASH if file == DASH else str(Path(file).with_suffix(ending)))
    if dry_run:
        check_targets([file], target, json_to)
        return None, None
    if events is None and not is_stream(target):
        events = target + EVENTS
    if (target, events, json_to).count(DASH) > 1:
        raise click.UsageError("only one of the stream, --events and --json can go to standard output")
    check_targets([file], target, events, json_to)
    return target, events


def _steps(
    file: str,
    printer: str | None,
    how: dict[str, Any],
    name: str,
    rate: float | None,
    targets: tuple[str | None, str | None],
    quiet: bool,
) -> tuple[StepsSummary, int]:
    """Read, plan, compensate, step and write; files appear when all of it is there. Also the stream's size."""
    from fbfcli.gcode.scan import chunks
    from fbfcli.gcode.stamp import looked_into
    from fbfcli.pipeline.steps import StepStream

    profile = find_file(printer)
    machine = read_printer(profile)
    with reading(file) as source, progress_bar(file, quiet) as progress, named(file, str(profile)):
        stamped, texts = looked_into(chunks(source))
        settings = _settings(file, how, stamped, quiet)
        stream = StepStream(machine, settings)
        with ExitStack() as files:
            writer = _writer(name, machine.driver, stream.motors, settings.dt, rate, files)
            write, write_event = (files.enter_context(_writing(target)) for target in targets)
            size = sum(map(write, writer.head()))
            for piece, happened in stream.pieces(texts, progress):
                size += sum(map(write, writer.add(piece)))
                for event in happened:
                    line = {"time": round(event.time, 6), "line": event.line, "text": event.text}
                    write_event(json.dumps(line).encode() + b"\n")
            size += sum(map(write, writer.end()))
        return stream.summary, size


def _settings(file: str, how: dict[str, Any], stamped: bool, quiet: bool) -> Settings:
    """As asked for; a file that is compensated already is not compensated again."""
    from fbfcli.pipeline.settings import AS_WRITTEN, AUTO

    if stamped:
        wanted = {**how, "method": None if how["method"] in (AUTO, AS_WRITTEN) else how["method"]}
        if given := next((option for option, value in wanted.items() if value is not None), None):
            option = given.replace("_", "-")
            raise click.UsageError(f"{file} is compensated already and taken as it is written: no --{option}")
        if not quiet:
            click.echo(f"{file}: is compensated already, taken as it is written", err=True)
        how = {"method": AS_WRITTEN}
    return settings_of(how, patch_times=False)


def _writer(name: str, driver: Driver, motors: Motors, dt: float, rate: float | None, files: ExitStack) -> Writer:
    """The format's writer; its temporary files are closed with `files`."""
    from fbfcli.cli.npz_archive import NpzWriter
    from fbfcli.steps.formats import WRITERS, Wanted

    if name == "npz":
        return NpzWriter(motors, files)
    return WRITERS[name](Wanted(motors, driver, dt, rate))


@contextmanager
def _writing(target: str | None) -> Iterator[Callable[[bytes], int]]:
    """Writes bytes to a file, to what `is_stream`, or nowhere, and says how many they were."""
    if target is None:
        yield len
        return
    with writing(target) as stream:

        def write(data: bytes) -> int:
            stream.write(data)
            return len(data)

        yield write
