"""A file's step stream is the file's motion: positions, ends, times and events."""

from __future__ import annotations

import io
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from print_cases import LIMITS, START, compensated, print_time, printer, prints, random_print, read

from fbfcli.cli.lookup import find_printer
from fbfcli.errors import LimitError
from fbfcli.gcode.scan import chunks
from fbfcli.motion import planner
from fbfcli.motion.kinematics import kinematics_of
from fbfcli.motion.sample import sample
from fbfcli.motion.timing import executed
from fbfcli.pipeline import Settings
from fbfcli.pipeline.choice import chosen
from fbfcli.pipeline.commander import Commander
from fbfcli.pipeline.designs import Designs
from fbfcli.pipeline.reader import Reader
from fbfcli.pipeline.steps import StepsSummary, StepStream
from fbfcli.pipeline.timeline import Event
from fbfcli.printer import Driver, Printer
from fbfcli.steps.compact import CompactWriter, read_compact
from fbfcli.steps.curve import position
from fbfcli.steps.stream import MotorSteps, joined

DT = 1e-3
NS = 1_000_000
NONE, ZV = Settings(method="none"), Settings(method="zv")
HALF = 0.5 + 0.5e-4 + 1e-4  # steps: half, half the hysteresis, and a motor's way in the nanosecond of a rounded time
KINEMATICS = ("cartesian", "corexy", "delta")


@dataclass(frozen=True)
class Stream:
    """All that came of a file; ticks and positions [steps] of every sample, motors in columns."""

    steps: tuple[MotorSteps, ...]
    tick: np.ndarray
    y: np.ndarray
    events: list[Event]
    summary: StepsSummary

    def standing(self, motor: int, at: np.ndarray) -> np.ndarray:
        """Where a motor stands at times `at` [ns]."""
        one = self.steps[motor]
        position = np.rint(self.y[0, motor]) + np.concatenate([[0], np.cumsum(np.where(one.forward, 1, -1))])
        return position[np.searchsorted(one.time, at, side="right")]


def machine(kinematics: str = "cartesian", firmware: str = "klipper") -> Printer:
    return replace(
        printer(firmware), kinematics=kinematics, e_steps_per_mm=415.0, delta_radius=400.0, arm_length=800.0
    )


def streamed(text: str | bytes, wanted: Printer, how: Settings, size: int = 1 << 19) -> Stream:
    source = text.encode() if isinstance(text, str) else text
    stream = StepStream(wanted, how)
    pieces, events = [], []
    for piece, happened in stream.pieces(chunks(io.BytesIO(source), size)):
        pieces.append(piece)
        events += happened
    rates = np.array(stream.motors.steps_per_mm)
    return Stream(
        tuple(joined([piece.steps.motors[i] for piece in pieces]) for i in range(len(rates))),
        np.concatenate([piece.tick for piece in pieces]),
        np.concatenate([piece.position for piece in pieces]) * rates,
        events,
        stream.summary,
    )


QUIET = ("print", "arc", "travel", "retract", "lift", "fan", "wipe", "spiral", "feed", "override", "reset")
every_kinematics = pytest.mark.parametrize("kinematics", KINEMATICS)


@every_kinematics
@pytest.mark.parametrize("how", [NONE, ZV], ids=["none", "zv"])
@settings(max_examples=15)
@given(text=prints("klipper", QUIET), data=st.data())
def test_steps_are_within_half_a_step_of_the_trajectory_everywhere(kinematics, how, text, data):
    got = streamed(text, machine(kinematics), how)
    seed = data.draw(st.integers(0, 999))
    dense = got.tick[0] + np.random.default_rng(seed).uniform(0, len(got.tick) - 1, 2000)
    assert (np.diff(got.tick) >= 1).all()
    for i in range(4):
        whole = np.interp(np.arange(got.tick[0], got.tick[-1] + 1), got.tick, got.y[:, i])  # rests filled
        at = np.concatenate([dense, got.tick, got.steps[i].time / NS])
        at = at[at <= got.tick[-1]]
        error = got.standing(i, at * NS) - position(whole, at - got.tick[0])
        assert np.abs(error).max() <= HALF
        turned = np.diff(got.steps[i].forward)
        assert (np.diff(got.steps[i].time)[turned] >= (1.9e-6 + 0.65e-6) * 1e9).all()


@every_kinematics
def test_a_real_part_is_within_half_a_step_and_small(kinematics, root):
    """Sliced by PrusaSlicer; the compact file of it holds every step within its tolerance."""
    wanted = replace(
        find_printer("synthetic_bed_slinger"), kinematics=kinematics, delta_radius=300.0, arm_length=620.0
    )
    stream = StepStream(wanted, NONE)
    with (root / "sample_gcode" / "star.gcode").open("rb") as file:
        pieces = [piece for piece, _ in stream.pieces(chunks(file))]
    writer = CompactWriter(stream.motors)
    data = b"".join([*writer.head(), *(part for piece in pieces for part in writer.add(piece)), *writer.end()])
    assert len(data) <= 2 * sum(one.steps for one in stream.summary.motors)
    tick = np.concatenate([piece.tick for piece in pieces])
    q = np.concatenate([piece.position for piece in pieces])
    for i, (name, rate) in enumerate(zip(stream.motors.names, stream.motors.steps_per_mm, strict=True)):
        steps, kept = joined([piece.steps.motors[i] for piece in pieces]), read_compact(data)[name]
        assert (kept.forward == steps.forward).all()
        assert np.abs(kept.time - steps.time).max() <= 1000
        standing = np.rint(q[0, i] * rate) + np.concatenate([[0], np.cumsum(np.where(steps.forward, 1, -1))])
        error = standing[np.searchsorted(steps.time, tick * NS, side="right")] - q[:, i] * rate
        assert np.abs(error).max() <= HALF
        assert standing[-1] == np.rint(q[-1, i] * rate) == stream.summary.motors[i].end


@every_kinematics
@settings(max_examples=15)
@given(text=prints("klipper", QUIET))
def test_counts_are_the_end_position_exactly(kinematics, text):
    got = streamed(text, machine(kinematics), ZV)
    moves = read(text, machine(kinematics)).moves
    end = moves.start[-1] + moves.delta[-1]
    q = np.append(kinematics_of(machine(kinematics)).motors(end[None, :3])[0], end[3])
    rates = [one.steps_per_mm for one in got.summary.motors]
    assert [one.end for one in got.summary.motors] == np.rint(np.round(q * rates, 6)).tolist()
    for told, steps, first in zip(got.summary.motors, got.steps, got.y[0], strict=True):
        assert told.steps == len(steps)
        assert np.rint(first) + steps.moved == told.end


@settings(max_examples=15)
@given(text=prints("klipper", ("print", "travel", "arc", "wipe")))
def test_uncompensated_it_is_the_firmwares_own_motion(text):
    """Without rests inside, against the planner's trapezoids between the samples too."""
    text = text.replace("G1 Z0.3 F900\n", "")
    got = streamed(text, machine(), NONE)
    moves = read(text, machine()).moves
    done = executed(moves, "klipper")
    t0 = np.cumsum(done.duration) - done.duration
    fine = 8  # per period
    x, _ = sample(moves.start, moves.delta, moves.distance, done, t0, fine * (len(got.tick) - 1), DT / fine)
    at = np.arange(len(x)) / fine
    on = np.arange(0, len(x), fine)
    assert np.allclose(got.y[: len(on), :2] / 80.0, x[on, :2], rtol=0, atol=1e-6)
    for i, rate in enumerate((80.0, 80.0)):
        error = got.standing(i, at * NS) - x[:, i] * rate
        assert np.abs(error).max() <= HALF + 80.0 * 2 * LIMITS.acceleration * DT**2  # what a bend hides in a period


def commands(text: str, wanted: Printer, how: Settings) -> np.ndarray:
    """X and Y of every stretch as `fbf compensate` computes them, one after the other."""
    commander = Commander(Designs(wanted, chosen(wanted, how).method, how), DT)
    reader = Reader(wanted, how)
    rows = []
    for portion in reader.portions(chunks(io.BytesIO(text.encode())), lambda done: None):
        batch = commander.batch(portion.part, portion.inside)
        rows.append(batch.command[1 if batch.begun else 0 :])
    return np.concatenate(rows)


@settings(max_examples=10)
@given(text=prints("klipper", ("print", "travel", "arc", "retract", "lift")))
def test_compensated_it_is_the_command(text):
    assert_command(text + "G1 X50 Y60 F6000\n", ZV)


def test_with_a_spline_method_it_is_the_command_too():
    assert_command(random_print(7, 12, "klipper", ("print", "arc", "retract")), Settings(method="fbf"))


def assert_command(text: str, how: Settings) -> None:
    """Where the machine moves, after the first move, whose start is not known, it is on the command."""
    command = commands(text, machine(), how)
    track = streamed(text, machine(), how).y[:, :2] / 80.0
    moving, along = (np.abs(np.diff(x, axis=0, prepend=x[:1])).max(axis=1) > 1e-7 for x in (command, track))
    assert np.allclose(command[moving], track[along][-np.count_nonzero(moving) :], rtol=0, atol=1e-9)


EVENT_AT_A_CUT = START + "G1 X101.132 Y118.487 E1\nG1 X92.926 Y113.122 E1\nM104 S28\nG1 X74.46 Y108.29 E1\n"


@settings(max_examples=10)
@given(text=prints("klipper"), size=st.sampled_from([64, 700, 5000]))
@example(EVENT_AT_A_CUT, 64)
def test_any_chunks_make_the_same_steps(text, size):
    assert_same(streamed(text, machine(), ZV), streamed(text, machine(), ZV, size))


@pytest.mark.parametrize("how", [NONE, ZV], ids=["none", "zv"])
def test_parts_of_a_long_stretch_make_the_same_steps(how, monkeypatch):
    text = START + "".join(f"G1 X{100 + 60 * (i % 2)} Y{100 + i} E1 F9000\n" for i in range(40))
    whole = streamed(text, machine(), how)
    monkeypatch.setattr(planner, "PART_S", 0.4)
    assert_same(whole, streamed(text, machine(), how))


def assert_same(one: Stream, other: Stream) -> None:
    """The same steps, times within what 1e-9 mm is at 0.1 mm/s."""
    for a, b in zip(one.steps, other.steps, strict=True):
        assert a.forward.tolist() == b.forward.tolist()
        assert (np.abs(a.time - b.time) <= 10_000).all()
    assert [(event.line, event.text) for event in one.events] == [(event.line, event.text) for event in other.events]
    assert np.allclose([event.time for event in one.events], [event.time for event in other.events], atol=1e-6)


def test_a_compensated_file_makes_the_steps_it_was_written_for():
    """The stream of the original, and that of the file `fbf compensate` makes of it, taken as written."""
    text = "G28\nG90\nM83\nG1 X100 Y100 F6000\n" + "".join(
        f"G1 X{100 + 60 * (i % 2)} Y{100 + 3 * i} E1 F9000\n" for i in range(20)
    )
    wanted = machine()
    there = streamed(compensated(text, wanted, ZV).text, wanted, NONE)
    here = streamed(text, wanted, ZV)
    assert [one.end for one in there.summary.motors] == [one.end for one in here.summary.motors]
    assert there.summary.time == pytest.approx(here.summary.time, abs=5 * DT)
    n = min(len(there.y), len(here.y))
    assert np.abs(there.y[:n, :2] - here.y[:n, :2]).max() / 80.0 < 0.03  # mm: a chord, and a few us of lateness


@settings(max_examples=10)
@given(text=prints("klipper"))
def test_the_clock_is_the_firmwares_and_whole_periods(text):
    got, wanted = streamed(text, machine(), NONE), print_time(text, machine())
    rests = 2 * text.count("\n")
    assert wanted - 1e-6 <= got.summary.time <= wanted + rests * DT


def test_events_come_at_their_time():
    text = "G28\nG90\nG1 X100 Y100 F6000\nM106 S1\nG1 X50\nM104 S200\nG4 P250\nM106 S2\nG1 X100\nM84\n;TIME:7\n"
    got = streamed(text, machine(), NONE)
    assert [(event.line, event.text) for event in got.events] == [
        (1, "G28"), (4, "M106 S1"), (6, "M104 S200"), (7, "G4 P250"), (8, "M106 S2"), (10, "M84"),
    ]  # fmt: skip
    time = {event.text: event.time for event in got.events}
    turn = got.tick[np.flatnonzero(got.y[:, 0] > 7999.0)[0]] * DT
    rest = got.tick[np.flatnonzero(np.diff(got.tick) > 1)[0]] * DT
    assert time["G28"] == 0.0
    assert time["M106 S1"] == pytest.approx(turn, abs=2 * DT)
    assert time["M104 S200"] == time["G4 P250"] == pytest.approx(rest, abs=2 * DT)
    assert time["M106 S2"] == pytest.approx(rest + 0.25, abs=2 * DT)
    assert time["M84"] == pytest.approx(got.summary.time, abs=2 * DT)


@settings(max_examples=10)
@given(text=prints("klipper"), how=st.sampled_from([NONE, ZV]))
def test_events_are_in_order(text, how):
    got = streamed(text, machine(), how)
    time = [event.time for event in got.events]
    assert [event.line for event in got.events] == sorted(event.line for event in got.events)
    assert (np.diff(time) >= -2 * DT).all()


def test_homing_in_the_middle_sets_the_motors():
    text = "G28\nG90\nG1 X100 Y50 F6000\nG28 X\nG1 X10 F6000\n"
    got = streamed(text, machine(), NONE)
    assert [one.end for one in got.summary.motors[:2]] == [800, 4000]
    assert [one.steps for one in got.summary.motors[:2]] == [8000 + 800, 4000]
    assert any("set to another position 1 times, first before line 5" in told for told in got.summary.warnings)


def test_a_rate_above_the_drivers_is_refused_with_line_and_time():
    slow = replace(machine(), driver=Driver(max_step_rate=7000.0))
    with pytest.raises(LimitError, match=r"line 4: at 1\.\d+ s motor y .* max_step_rate = 7,000") as told:
        streamed("G28\nG90\nG1 X80 Y0 F4800\nG1 Y90 F6000\n", slow, NONE)
    assert "8,000" in str(told.value) or "7,0" in str(told.value)


def test_a_position_out_of_the_arms_reach_is_refused_with_its_line():
    short = replace(machine("delta"), delta_radius=100.0, arm_length=150.0)
    with pytest.raises(LimitError, match=r"line 4: X\S+ Y\S+ Z\S+ is out of the arms' reach"):
        streamed("G28\nG90\nG1 X10 Y10 F6000\nG1 X90 Y90\n", short, NONE)


def test_without_its_steps_per_mm_e_stands_and_that_is_told():
    got = streamed(START, replace(machine(), e_steps_per_mm=None), NONE)
    assert [one.name for one in got.summary.motors] == ["x", "y", "z"]
    assert any("steps_per_mm" in told for told in got.summary.warnings)
