"""From planned moves to commands: stretches sampled, compensated, and kept within the machine's limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fbfcli.control.compensator import Stream
from fbfcli.control.limits import clip, outside
from fbfcli.errors import LimitError
from fbfcli.motion.moves import E
from fbfcli.motion.planner import Part
from fbfcli.motion.sample import sample
from fbfcli.motion.stretches import Grid, Rests, lay, scaled, stretch_starts
from fbfcli.pipeline.designs import Designs

SLOWER = 1.25  # a stretch that leaves the limits takes this many times longer, until it does not
SLOWEST = 8.0


@dataclass(frozen=True)
class Batch:
    """Commands of a part that are final; n samples of s stretches.

    grid       : Grid                            of all stretches of the part, its sample 0 being row 0 here
    begin, end : ndarray of int, shape (s,)      first and last sample of each stretch here
    start      : ndarray of int, shape (s,)      move of the part that each begins, or goes on, with
    line       : ndarray of int, shape (s,)      line of the file that each began with
    begun      : bool                            the first of them was begun in an earlier batch
    desired    : ndarray, shape (n, 4)           X Y Z E [mm]
    command    : ndarray, shape (n, 2)           X Y [mm]
    extruding  : ndarray of bool, shape (n,)
    asked      : ndarray of int, shape (n,)      line of the file that asks for each sample
    filament   : ndarray, shape (n,)             E as sliced [mm]
    place      : ndarray of int, shape (n,)      where the print is, as `Designs` tells places apart
    dropped    : int                             samples that the next batch does not see again
    """

    grid: Grid
    begin: np.ndarray
    end: np.ndarray
    start: np.ndarray
    line: np.ndarray
    begun: bool
    desired: np.ndarray
    command: np.ndarray
    extruding: np.ndarray
    asked: np.ndarray
    filament: np.ndarray
    place: np.ndarray
    dropped: int

    @property
    def goes_on(self) -> bool:
        """The last of the stretches goes on in the next batch."""
        return self.grid.open_last and self.dropped < len(self.command)


@dataclass(frozen=True)
class _Samples:
    """Rows of a trajectory: desired (n, 4), extruding and line (n,), and the commands known so far (k <= n, 2)."""

    desired: np.ndarray
    extruding: np.ndarray
    line: np.ndarray
    command: np.ndarray

    def __getitem__(self, rows: slice) -> _Samples:
        return _Samples(self.desired[rows], self.extruding[rows], self.line[rows], self.command[rows])


@dataclass(frozen=True)
class _Open:
    """A stretch that goes on in the next part: its samples from the last one written on."""

    stream: Stream
    phase: float
    begun: bool
    line: int
    samples: _Samples


class _Attempt:
    """One stretch: how stiff the compensator, how many times slower, and the command if it stands.

    fixed   : it began in an earlier part
    goes_on : it goes on in a later one
    """

    def __init__(self, fixed: bool, goes_on: bool):
        self.fixed, self.goes_on = fixed, goes_on
        self.level, self.slow = 0, 1.0
        self.command: np.ndarray | None = None
        self.stream: Stream | None = None


class Remedies:
    """Stretches that needed one to stay within the limits."""

    def __init__(self) -> None:
        self.stretches = self.stiffened = self.slowed = 0
        self.slowest = 1.0
        self.first_line: int | None = None
        self._is_stiff = False  # the stretch that may go on

    def count(self, attempt: _Attempt, line: int) -> None:
        """An attempt that stands; attempts come in order."""
        if not attempt.fixed:
            self.stretches += 1
            self._is_stiff = False
        self.slowed += attempt.slow > 1.0
        if attempt.level > 0 and attempt.slow == 1.0 and not self._is_stiff:
            self.stiffened += 1
            self._is_stiff = True
        self.slowest = max(self.slowest, attempt.slow)
        if self.first_line is None and (attempt.level or attempt.slow > 1.0):
            self.first_line = line + 1

    @property
    def told(self) -> str:
        """A warning, empty where no stretch needed a remedy."""
        if not (self.stiffened or self.slowed):
            return ""
        return (
            f"limits: {self.stiffened} of {self.stretches} stretches compensated more gently, "
            f"{self.slowed} slowed (up to {self.slowest:.2f} times), the first at line {self.first_line}"
        )


class Commander:
    """Commands for the moves of one file, part by part."""

    def __init__(self, designs: Designs, dt: float):
        self._designs, self._dt = designs, dt
        compensator = designs.compensator(0)
        self._rests = Rests(compensator.lead, compensator.tail, 0)
        self._open: _Open | None = None
        self.remedies = Remedies()

    def batch(self, part: Part, inside: np.ndarray) -> Batch:
        """The commands that are final with this part. Raises LimitError where limits cannot be kept."""
        goes_on = bool(len(inside) and inside[-1] and part.next is not None and not part.next.stop[0])
        starts = stretch_starts(part.moves, inside)
        attempts = [_Attempt(bool(j == 0 and self._open), goes_on and j == len(starts) - 1) for j in range(len(starts))]
        lines = part.moves.line[starts].tolist()
        if self._open:
            lines[0] = self._open.line
        while True:
            grid, desired, move = self._sampled(part, inside, attempts)
            self._attempt(grid, desired, attempts)
            extruding, line = part.moves.delta[move, E] > 0.0, part.moves.line[move]
            grid, samples = self._joint(grid, _Samples(desired, extruding, line, _joined(attempts)))
            bad = self._violations(grid, samples)
            if not len(bad):
                break
            for j in bad.tolist():
                self._remedy(attempts[j], lines[j])
        for attempt, line in zip(attempts, lines, strict=True):
            self.remedies.count(attempt, line)
        return self._finish(grid, samples, starts, np.array(lines, dtype=np.int64), attempts)

    def _sampled(self, part: Part, inside: np.ndarray, attempts: list[_Attempt]) -> tuple[Grid, np.ndarray, np.ndarray]:
        """Grid, desired positions and moves of the samples, of the stretches of a part (an open one: its new ones)."""
        profile = part.profile
        slow = np.array([attempt.slow for attempt in attempts])
        if (slow != 1.0).any():
            stretch = np.searchsorted(stretch_starts(part.moves, inside), np.arange(len(inside)), side="right") - 1
            profile = scaled(profile, np.where(inside, slow[stretch], 1.0))
        phase = self._open.phase if self._open else None
        goes_on = bool(attempts and attempts[-1].goes_on)
        grid = lay(part.moves, inside, profile.duration, self._dt, self._rests, phase, goes_on)
        if not len(grid.move):
            return grid, np.zeros((0, 4)), np.zeros(0, dtype=np.int64)
        moves, timing = (part.moves, profile) if inside.all() else (part.moves[grid.move], profile[grid.move])
        x, index = sample(moves.start, moves.delta, moves.distance, timing, grid.t0 * self._dt, grid.count, self._dt)
        new = slice(1 if self._open else 0, None)
        for k in range(self._rests.lead + 1):  # before its first move a stretch rests where that begins
            x[grid.begin[new] + k] = moves.start[grid.first[:-1][new]]
        return grid, x, grid.move[index]

    def _attempt(self, grid: Grid, desired: np.ndarray, attempts: list[_Attempt]) -> None:
        """Compensate every stretch that has no command yet."""
        weight = np.ones(len(desired))  # travel too: at 0.1 what prints gains 0.5 % and commands are 3 % faster
        for attempt, a, b in zip(attempts, grid.begin.tolist(), (grid.end + 1).tolist(), strict=True):
            if attempt.command is None:
                self._compensate(attempt, desired[a:b], weight[a:b])

    def _compensate(self, attempt: _Attempt, desired: np.ndarray, weight: np.ndarray) -> None:
        """The command of a stretch, in pieces where the models change on the way."""
        before = self._open if attempt.fixed else None
        stream = before.stream if before else None
        commands = []
        for place, rows in self._pieces(desired, before.samples.desired[1:] if before else desired[:0]):
            compensator = self._designs.compensator(place, attempt.level)
            stream = compensator.resume(stream) if stream else compensator.start(desired[0, :2])
            last = not attempt.goes_on and rows.stop == len(desired)
            commands.append(stream.push(desired[rows, :2], weight[rows], last))
        attempt.stream, attempt.command = stream, np.concatenate(commands)

    def _pieces(self, desired: np.ndarray, earlier: np.ndarray) -> list[tuple[int, slice]]:
        """Places of a stretch's new samples, and the rows to push under the design of each: as early as it asks for.

        earlier : the samples before them whose commands are not final
        """
        place = self._designs.places(np.concatenate([earlier, desired]))
        final = np.arange(len(desired)) + len(earlier) - self._designs.compensator(0).notice
        here = place[np.maximum(final, 0)]
        cuts = [0, *(np.flatnonzero(np.diff(here)) + 1).tolist(), len(desired)]
        return [(int(here[i]), slice(i, j)) for i, j in pairwise(cuts)]

    def _joint(self, grid: Grid, samples: _Samples) -> tuple[Grid, _Samples]:
        """What is left of an open stretch put in front of its new samples."""
        if not self._open:
            return grid, samples
        left = self._open.samples
        shift = len(left.desired)
        grid = replace(
            grid,
            begin=np.concatenate([[0], grid.begin[1:] + shift]),
            end=grid.end + shift,
            t0=grid.t0 + shift,
            count=grid.count + shift,
        )
        return grid, _Samples(
            np.concatenate([left.desired, samples.desired]),
            np.concatenate([left.extruding, samples.extruding]),
            np.concatenate([left.line, samples.line]),
            np.concatenate([left.command, samples.command]),
        )

    def _violations(self, grid: Grid, samples: _Samples) -> np.ndarray:
        """Indices of the stretches whose command leaves the limits."""
        u = samples.command
        begin = grid.begin[grid.begin < len(u)]
        if not len(begin) or self._designs.method == "none":
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(outside(u, samples.desired[: len(u), :2], begin, self._dt, self._designs.box))

    def _remedy(self, attempt: _Attempt, line: int) -> None:
        """Stiffer first, then slower."""
        stiffer, now = (self._designs.compensator(0, level) for level in (attempt.level + 1, attempt.level))
        if stiffer is not now:
            attempt.level += 1
        elif attempt.slow < SLOWEST and not (attempt.fixed or attempt.goes_on):
            attempt.slow *= SLOWER
        else:
            raise LimitError(_TOO_FAST.format(line + 1))
        attempt.command = None

    def _finish(
        self, grid: Grid, samples: _Samples, starts: np.ndarray, lines: np.ndarray, attempts: list[_Attempt]
    ) -> Batch:
        """Keep back what is not final."""
        before, begin = self._open, grid.begin
        n = dropped = len(samples.command)
        self._open = None
        if attempts and attempts[-1].goes_on and attempts[-1].stream:
            writes = n - begin[-1] >= 2
            if writes:
                dropped = n - 1
            else:
                n = dropped = int(begin[-1])
            begun = bool(writes or (before and before.begun and len(begin) == 1))
            self._open = _Open(attempts[-1].stream, grid.phase, begun, int(lines[-1]), samples[dropped:])
        here = begin < n
        command = samples.command[:n]
        if self._designs.method != "none":
            command = clip(command, self._designs.box)
        return Batch(
            grid,
            begin[here],
            np.minimum(grid.end[here], n - 1),
            starts[here],
            lines[here],
            bool(before and before.begun),
            samples.desired[:n],
            command,
            samples.extruding[:n],
            samples.line[:n],
            samples.desired[:n, E],
            self._designs.places(samples.desired[:n]),
            dropped,
        )


_TOO_FAST = (
    "line {}: the compensated command leaves the printer's limits; plan with a lower --accel, or give a larger --mu"
)


def _joined(attempts: list[_Attempt]) -> np.ndarray:
    """The commands one after the other, shape (n, 2)."""
    return np.concatenate(
        [attempt.command for attempt in attempts if attempt.command is not None] or [np.zeros((0, 2))]
    )
