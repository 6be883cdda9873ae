"""`fbf compensate`: G-code in, G-code out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import click

from fbfcli.cli.files import DASH, check_targets, is_stream, one_stream, reading, writing
from fbfcli.cli.lookup import find_file, read_printer
from fbfcli.cli.method_options import method_options, settings_of
from fbfcli.cli.options import json_option, printer_option, quiet_option, segments_option, tolerance_option
from fbfcli.cli.pictures import Pictures, report_option
from fbfcli.cli.telling import named, progress_bar, tell_json
from fbfcli.errors import FbfError

if TYPE_CHECKING:
    from fbfcli.pipeline import Done, Settings

SUFFIX = ".fbf"


@click.command(no_args_is_help=False)
@click.argument("file", default=DASH, metavar="[FILE]")
@printer_option
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="Write here; - is standard output. [default: FILE with .fbf before its ending]",
)
@click.option("-i", "--in-place", is_flag=True, help="Change FILE itself, as slicers expect of a post-processor.")
@method_options
@tolerance_option
@segments_option
@report_option
@json_option
@click.option(
    "--log", "log_to", metavar="FILE", help="Append the summary, or the error, to a file (Windows slicers hide both)."
)
@click.option("-n", "--dry-run", is_flag=True, help="Compute and tell everything, write nothing.")
@click.option("-f", "--force", is_flag=True, help="Compensate a file that is compensated already.")
@quiet_option
def compensate(
    file: str,
    printer: str | None,
    output: str | None,
    in_place: bool,
    report: str | None,
    json_to: str | None,
    log_to: str | None,
    dry_run: bool,
    force: bool,
    quiet: bool,
    **how: Any,
) -> None:
    """Change a print so that a vibrating printer follows it.

    The motion is planned as the firmware would, the printer's measured vibration is inverted, and the result is
    written as short segments whose times the firmware keeps. Other lines stay where they belong in time.

    \b
    fbf compensate part.gcode -p synthetic_bed_slinger       writes part.fbf.gcode
    fbf compensate part.gcode -p taz6 --accel 5000           plans with a higher acceleration
    fbf compensate -i -p ~/my_printer.toml part.gcode        in a slicer's post-processing box
    fbf compensate part.gcode -p taz6 --report part.html     shows before and after
    fbf compensate part.gcode -p taz6 --spread 10            trusts the model within 10 %
    fbf compensate -p taz6 -m zv --dry-run --json - part.gcode | jq .contour_after
    zcat part.gcode.gz | fbf compensate -p taz6 - > out.gcode
    """
    with _logged(log_to):
        target = _target(file, output, in_place, dry_run, json_to, report, log_to)
        settings = settings_of(how, patch_times=target is not None and not is_stream(target))
        done = _compensate(file, target, printer, settings, Pictures(report), force, quiet)
        if not quiet:
            click.echo(done.summary.text(), err=True)
        if json_to:
            tell_json(json_to, done.summary.as_dict())
        if log_to:
            _log(log_to, f"{file}: {done.summary.text()}")


def _target(file: str, output: str | None, in_place: bool, dry_run: bool, *told: str | None) -> str | None:
    """Where the new text goes: a file, standard output, or (None) nowhere. `told`: other files to be written."""
    if in_place and (file == DASH or output):
        raise click.UsageError("-i changes FILE itself: it takes a file, and no -o")
    target = None if dry_run else file if in_place else output or (DASH if file == DASH else _beside(file))
    one_stream(target, *told)
    check_targets([file], *told)
    check_targets([], target, *told)  # FILE may be changed itself
    return target


def _beside(file: str) -> str:
    path = Path(file)
    return str(path.with_name(path.stem + SUFFIX + path.suffix))


def _compensate(
    file: str,
    target: str | None,
    printer: str | None,
    settings: Settings,
    pictures: Pictures,
    force: bool,
    quiet: bool,
) -> Done:
    """Read, compensate and write; a file appears when all of it is there."""
    from fbfcli.gcode.scan import chunks
    from fbfcli.gcode.stamp import looked_into
    from fbfcli.pipeline import compensate as run

    profile = find_file(printer)
    machine = read_printer(profile)
    with reading(file) as source, progress_bar(file, quiet) as progress, named(file, str(profile)):
        stamped, texts = looked_into(chunks(source))
        if stamped and not force:
            raise FbfError(
                f"{file}: is compensated already; a second pass would shake the print (--force if it must be)"
            )
        with _writing(target) as write:
            if not pictures.watchers:
                done = run(texts, machine, settings, write.text, progress)
            else:
                from fbfcli.pipeline.before_after import BeforeAfter

                drawn = BeforeAfter(machine, settings, pictures.watchers)
                done = run(drawn.passing(texts), machine, settings, write.text, progress, drawn.watch)
                pictures.write(file, drawn.simulation(done), machine, machine, settings)
            write.fill_in(done)
        return done


class _Writer:
    """Takes the new text; `stream` is None for a dry run."""

    def __init__(self, stream: BinaryIO | None):
        self._stream = stream

    def text(self, text: bytes) -> None:
        if self._stream:
            self._stream.write(text)

    def fill_in(self, done: Done) -> None:
        """Put the print's times where they were left open."""
        if self._stream:
            for patch in done.patches:
                self._stream.seek(patch.offset)
                self._stream.write(patch.line.padded(patch.elapsed, done.time))


@contextmanager
def _writing(target: str | None) -> Iterator[_Writer]:
    if target is None:
        yield _Writer(None)
        return
    with writing(target) as stream:
        yield _Writer(stream)


@contextmanager
def _logged(log_to: str | None) -> Iterator[None]:
    """Errors go to the log too."""
    try:
        yield
    except (FbfError, OSError) as error:
        if log_to:
            _log(log_to, f"error: {error}")
        raise


def _log(log_to: str, words: str) -> None:
    with Path(log_to).open("a", encoding="utf-8") as stream:
        stream.write(words + "\n")
