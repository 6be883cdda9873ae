"""The order of the steps: text, moves, plan, trajectory, command, nodes, text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from fbfcli import __version__
from fbfcli.errors import ProfileError
from fbfcli.gcode.stamp import stamp
from fbfcli.motion.budget import MARLIN_STEPS, Budget
from fbfcli.pipeline.choice import Choice, chosen
from fbfcli.pipeline.commander import Commander, Remedies
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.filament import Filament
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.scribe import Patch, Scribe
from fbfcli.pipeline.segmenter import Segmenter
from fbfcli.pipeline.settings import Settings
from fbfcli.pipeline.summary import BUSY, Summary
from fbfcli.plant.coupling import coupling
from fbfcli.printer import Printer
from fbfcli.verify.contour_error import Errors
from fbfcli.verify.tally import Stretches, Tally

FEW_MOVES, FEW = 10, 0.01  # moves left alone that are not worth a warning: the first ones of every print
WORSE = 1.05  # times the uncompensated error that is told of
COUPLED = "what an axis' command adds to the other one (coupling) is in the predicted errors, but it is not compensated"
REPRAP_SPEED = 0.55  # mm/s, just above MinimumMovementSpeed: RepRapFirmware makes slower moves faster


@dataclass(frozen=True)
class Done:
    """A file that has been compensated, and the times to be filled in."""

    summary: Summary
    patches: tuple[Patch, ...]
    time: float


def compensate(
    chunks: Iterable[bytes],
    printer: Printer,
    settings: Settings,
    write: Callable[[bytes], object],
    progress: Callable[[int], None] = lambda done: None,
    watch: Callable[[Stretches], None] = lambda part: None,
) -> Done:
    """Compensate a file.

    chunks   : its text, whole lines
    write    : takes the new text
    progress : told how many bytes of the old text have been read
    watch    : told what the firmware makes of the new text, stretches by stretches

    Raises GcodeError (without the file's name), LimitError, ModelError, ProfileError.
    """
    check_ceilings(printer, settings)
    choice = chosen(printer, settings)
    budget = _budget(printer, settings)
    designs = Designs(printer, choice.method, settings)
    coupled = coupling(printer, settings.dt)
    tally = Tally(designs.b_a, watch, coupled)
    told = stamp(__version__, f'printer="{printer.name}" {settings.told(choice.method)}')
    commander = Commander(designs, settings.dt)
    filament = Filament(designs, settings)
    segmenter = Segmenter(printer, designs.b_a(0), budget, settings.dt)
    scribe = Scribe(printer.firmware, printer.limits, segmenter, tally, write, told, settings.patch_times)
    reader = Reader(printer, settings)
    for portion in reader.portions(chunks, progress):
        batch = filament.pushed(commander.batch(portion.part, portion.inside))
        scribe.batch(batch, portion.part, portion.inside, portion.lines, portion.table)
    scribe.finish()
    summary = _summary(printer, choice, settings, budget, reader, scribe, tally, commander.remedies)
    return Done(summary, tuple(scribe.patches), scribe.elapsed)


def check_ceilings(printer: Printer, settings: Settings) -> None:
    """Refuse to plan with more than the machine is said to stand."""
    for axis in printer.axes[:2]:
        for option, value, key, most in (
            ("--accel", settings.acceleration, "command_acceleration", axis.command_acceleration),
            ("--velocity", settings.velocity, "command_velocity", axis.command_velocity),
        ):
            if value is not None and value > most:
                raise ProfileError(
                    f"{option} {value:g} is more than the machine stands: {key} of axis {axis.name} is {most:g} in the "
                    f"profile of {printer.name}"
                )


def _budget(printer: Printer, settings: Settings) -> Budget:
    rate = settings.segments_per_second or printer.segments_per_second
    coarsest = min(axis.steps_per_mm for axis in printer.axes[:2])
    return Budget(
        settings.tolerance,
        rate,
        min_length=MARLIN_STEPS / coarsest if printer.firmware == "marlin" else 0.0,
        min_speed=REPRAP_SPEED if printer.firmware == "reprapfirmware" else 0.0,
    )


def _summary(
    printer: Printer,
    choice: Choice,
    settings: Settings,
    budget: Budget,
    reader: Reader,
    scribe: Scribe,
    tally: Tally,
    remedies: Remedies,
) -> Summary:
    return Summary(
        printer=printer.name,
        method=choice.method,
        why=choice.why,
        settings=settings.told(choice.method),
        time_as_sliced=reader.time_as_sliced + scribe.dwelt,
        time=scribe.elapsed,
        lines=reader.count,
        moves=reader.moves,
        left_alone=reader.left_alone,
        segments=tally.segments,
        segments_per_second=tally.rate,
        busiest_second=tally.busiest,
        budget=budget.max_rate,
        follow_error=Errors(**tally.follow.figures()),
        chord_error=Errors(**tally.chord.figures()),
        clock_drift_ppm=tally.drift_ppm,
        contour_before=Errors(**tally.before.figures()),
        contour_after=Errors(**tally.after.figures()),
        stretches=remedies.stretches,
        stiffened=remedies.stiffened,
        slowed=remedies.slowed,
        slowest=remedies.slowest,
        warnings=_warnings(printer, reader, tally, budget, remedies),
    )


def _warnings(printer: Printer, reader: Reader, tally: Tally, budget: Budget, remedies: Remedies) -> tuple[str, ...]:
    told = list(reader.warnings)
    if any(axis.coupling is not None for axis in printer.axes):
        told.append(COUPLED)
    if remedies.told:
        told.append(remedies.told)
    if tally.busiest > BUSY * budget.max_rate:
        told.append(f"{tally.busiest} segments in one second, more than the firmware takes: raise --tolerance")
    before, after = (errors.figures()["rms"] for errors in (tally.before, tally.after))
    if after > WORSE * before:
        told.append(f"predicted to be worse than uncompensated ({before:.1f} -> {after:.1f} um): take another --method")
    if not tally.segments:
        told.append("nothing was compensated: no move of X or Y has a known start")
    elif reader.left_alone > max(FEW_MOVES, FEW * reader.moves):
        told.append(f"{reader.left_alone} moves of X or Y left as they are: unknown start, or Z too steep to follow")
    return tuple(told)
