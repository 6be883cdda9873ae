"""`fbf identify`: recordings in, the model of an axis in a printer profile out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fbfcli.cli.files import DASH, check_targets, is_stream, reading, saying, writing
from fbfcli.cli.options import Number, json_option, quiet_option
from fbfcli.cli.place_option import At
from fbfcli.cli.telling import tell_json
from fbfcli.errors import FbfError, RecordingError
from fbfcli.units import UM_PER_MM

if TYPE_CHECKING:
    from fbfcli.pipeline.identified import Identified
    from fbfcli.plant.excitation import Sweep

AVERAGING = ("short-time", "welch")  # as plant.spectra and plant.frf have them, without importing numpy
ESTIMATORS = ("h1", "h2", "hv")
UNITS = ("mm/s^2", "m/s^2", "g", "mg")
PICTURES = ("png", "svg", "pdf")


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--axis", type=click.Choice(["x", "y"]), help="The axis that was moved. [default: what the file says]")
@click.option("-o", "--output", metavar="FILE", help="Profile to create or update; - writes it to standard output.")
@click.option("--at", "at", type=At(), metavar="x=MM,y=MM,z=MM,mass=KG", help="Where this was recorded: the profile "
              "keeps a model for each place. Any of the four.")  # fmt: skip
@click.option("--plot", "plot_to", metavar="FILE", help="Picture of response and model: .png, .svg or .pdf.")
@click.option("--sweep", metavar="TEST|CSV", help="The test that was run: klipper, klipper-2020, marlin, ulendo, with "
              "settings as klipper:f1=100,accel_per_hz=75; or the CSV that `fbf excite` wrote.")  # fmt: skip
@click.option("--band", type=Number(0.5, 1000), nargs=2, default=(5.0, 200.0), show_default=True, metavar="HZ HZ",
              help="Frequencies to look at.")  # fmt: skip
@click.option("--averaging", type=click.Choice(AVERAGING), default="short-time", show_default=True,
              help="short-time follows a sweep, welch is for noise.")  # fmt: skip
@click.option("--estimator", type=click.Choice(ESTIMATORS), default="h1", show_default=True,
              help="Where the noise is: h1 in the response, h2 in the command, hv in both.")  # fmt: skip
@click.option("--error", type=Number(0.1, 10000), default=50.0, show_default=True, metavar="UM",
              help="Tell the acceleration up to which motion stays within this error.")  # fmt: skip
@click.option("--time", "time", metavar="COLUMN", help="Column of times: name or number.")
@click.option("--command", metavar="COLUMN", help="Column of the command: name or number.")
@click.option("--measured", metavar="COLUMN", help="Column of the measurement: name or number.")
@click.option("--unit", type=click.Choice(UNITS), help="Unit of the accelerations. [default: recognised]")
@click.option("--rate", type=Number(min=10), metavar="HZ", help="Sampling rate, of a file without times.")
@json_option
@quiet_option
def identify(
    files: tuple[str, ...],
    output: str | None,
    plot_to: str | None,
    json_to: str | None,
    at: dict[str, float] | None,
    quiet: bool,
    **how: Any,
) -> None:
    """Find how an axis vibrates from recordings of its acceleration, and write it into a printer profile.

    Recordings of one axis are combined. They are recognised by what they hold: command and measurement, Klipper's raw
    data and spectra, RepRapFirmware's M956, Ulendo's JSON, frequency responses. The command of a known test is rebuilt
    and aligned. Comments in a profile stay.

    \b
    fbf identify raw_data_x_20240101_120000.csv --axis x -o my_printer.toml --plot bode.png
    fbf identify run1.csv run2.csv --axis y -o my_printer.toml       uncertainty from two runs
    fbf identify y_at_20.csv --axis y --at y=20 -o my_printer.toml   one of several places
    fbf identify capture.csv --axis x --sweep sweep_x.csv            what `fbf excite` made the printer do
    fbf identify log.csv --time t --command u --measured a --axis x --unit g
    cat raw.csv | fbf identify - --axis x --json - -q | jq .modes
    """
    if at and not output:
        raise click.UsageError("--at says where the profile's model holds: give the profile with -o")
    _check_targets(files, output, plot_to, json_to)
    found = _identified(files, how)
    if output:
        _write_profile(output, found, at)
    if plot_to:
        _write_picture(plot_to, found)
    if json_to:
        tell_json(json_to, found.as_dict())
    if not quiet:
        click.echo(found.text(), err=True)


def _check_targets(files: tuple[str, ...], output: str | None, plot_to: str | None, json_to: str | None) -> None:
    """Refuse before any work what could not be written after it."""
    if [output, json_to, plot_to].count(DASH) > 1:
        raise click.UsageError("only one of -o, --plot and --json can go to standard output")
    check_targets(files, output, plot_to, json_to)
    if plot_to and plot_to != DASH and Path(plot_to).suffix.lower().lstrip(".") not in PICTURES:
        raise click.UsageError(f"--plot {plot_to}: the ending must be one of {', '.join(PICTURES)}")


def _identified(files: tuple[str, ...], how: dict[str, Any]) -> Identified:
    from fbfcli.pipeline.ask import Ask
    from fbfcli.pipeline.identify import identify
    from fbfcli.plant.recording import ReadOptions

    if how["band"][0] * 2 > how["band"][1]:
        raise click.UsageError("--band: the second frequency must be twice the first, or more")
    ask = Ask(
        axis=how["axis"],
        sweep=_sweep(how["sweep"]),
        band=how["band"],
        averaging=how["averaging"],
        estimator=how["estimator"],
        error=how["error"] / UM_PER_MM,
        read=ReadOptions(how["time"], how["command"], how["measured"], how["unit"], how["rate"]),
    )
    return identify([_content(name) for name in files], ask)


def _content(name: str) -> tuple[str, bytes]:
    with reading(name) as stream:
        return ("standard input" if name == DASH else name), stream.read()


def _sweep(words: str | None) -> Sweep | None:
    """A test by its name, or the command that a CSV holds."""
    if words is None:
        return None
    from fbfcli.plant.sweep_spec import named_sweep, sweep_of_csv

    if Path(words).is_file():
        return sweep_of_csv(_content(words)[1], words)
    if "." in Path(words).name and ":" not in words:
        raise RecordingError("no such file", file=words, remedy="--sweep takes a test's name or a CSV")
    return named_sweep(words)


def _write_profile(output: str, found: Identified, at: dict[str, float] | None) -> None:
    """A new profile, or the old one with this axis' model, or with its model at a place."""
    from fbfcli.printer import Place
    from fbfcli.printer_toml import parse_printer
    from fbfcli.profile_text import new_profile, with_model, with_model_at

    is_old = not is_stream(output) and Path(output).exists()
    if is_old:
        with reading(output) as stream:
            text = _decoded(stream.read(), output)
    else:
        name = Path(output).stem if output != DASH else "my printer"
        text = new_profile(name, "measured; limits and travel are guesses")
    if at:
        text = with_model_at(text, output, found.axis, Place(found.model, **at), found.ranges, found.note())
    else:
        text = with_model(text, output, found.axis, found.model, found.spread, found.note())
    parse_printer(text, output, lambda name: (Path(output).parent / name).read_text(encoding="utf-8-sig"))
    with saying(output) as say:
        say(text)


def _decoded(data: bytes, name: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FbfError(f"{name}: is not text in UTF-8") from None


def _write_picture(plot_to: str, found: Identified) -> None:
    from fbfcli.pipeline.identified_picture import picture

    kind = "png" if plot_to == DASH else Path(plot_to).suffix.lower().lstrip(".")
    image = picture(found, kind)
    with writing(plot_to) as stream:
        stream.write(image)
