"""What is told of a compensated file, for people and for scripts."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from fbfcli.pipeline.rows import told
from fbfcli.verify.contour_error import Errors

BUSY = 1.25  # seconds may be this much fuller than the firmware's rate before they are told of


@dataclass(frozen=True)
class Summary:
    """Figures of one compensated file; times [s], errors [um].

    method, why          : the method that was taken, and why where fbf chose or assumed something
    time_as_sliced       : as the firmware would print the input
    time                 : as it prints the output
    lines, moves         : of the input
    left_alone           : moves of X or Y that were passed through uncompensated
    segments             : written
    segments_per_second  : mean over compensated motion; `busiest_second` the most in one second
    budget               : segments per second that the firmware takes
    follow_error         : executed position of the written file against the polyline it stands for, segment by
                           segment at the wanted time
    chord_error          : that polyline against the smooth command; where the firmware takes fewer or no shorter
                           segments than the tolerance asks for, it is fitted so that the nozzle comes out best
    clock_drift_ppm      : executed time of the written segments against the wanted time
    contour_before, contour_after : predicted distance of the nozzle from the desired path while extruding,
                           of the same plan uncompensated and of the written file
    stretches, stiffened, slowed, slowest : rests to rests; those that limits made stiffer or slower; the largest factor
    """

    printer: str
    method: str
    why: str
    settings: str
    time_as_sliced: float
    time: float
    lines: int
    moves: int
    left_alone: int
    segments: int
    segments_per_second: float
    busiest_second: int
    budget: float
    follow_error: Errors
    chord_error: Errors
    clock_drift_ppm: float
    contour_before: Errors
    contour_after: Errors
    stretches: int
    stiffened: int
    slowed: int
    slowest: float
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """For --json."""
        return asdict(self)

    def text(self) -> str:
        """For people, on stderr."""
        before, after = self.contour_before, self.contour_after
        follow, chord = self.follow_error, self.chord_error
        rows = [
            ("print time", f"{clock(self.time_as_sliced)} -> {clock(self.time)}"),
            (
                "segments",
                f"{self.segments_per_second:.0f}/s mean, {self.busiest_second}/s at most; "
                f"the firmware takes {self.budget:.0f}/s",
            ),
            (
                "follow error",
                f"{follow.rms:.1f} um rms, {follow.max:.1f} um max; clock drift {self.clock_drift_ppm:+.2f} ppm",
            ),
            ("chord error", f"{chord.rms:.1f} um rms, {chord.max:.1f} um max: written segments off the smooth command"),
            (
                "contour error",
                f"{before.rms:.1f} -> {after.rms:.1f} um rms, {before.p99:.0f} -> {after.p99:.0f} um 99 %, "
                f"{before.max:.0f} -> {after.max:.0f} um max (extruding, predicted)",
            ),
            ("method", f"{self.method} ({self.why})" if self.why else self.method),
        ]
        return told(rows, self.warnings)


def clock(seconds: float) -> str:
    """1 h 02 min 03 s."""
    minutes, s = divmod(round(seconds), 60)
    hours, m = divmod(minutes, 60)
    return f"{hours} h {m:02d} min {s:02d} s" if hours else f"{m} min {s:02d} s"
