"""The tables of a report: figures of a simulation, in words and rounded for people."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fbfcli.pipeline.simulation import Simulated, Simulation
from fbfcli.pipeline.summary import clock
from fbfcli.verify.account import Accounted
from fbfcli.verify.subject import Sheet

Named = Sequence[tuple[str, Simulated]]  # results, and what people call them


def methods(shown: Named) -> Sheet:
    """Every method's print time and errors."""
    return Sheet(
        "Method against method",
        "While something is printed: distance of the nozzle from the path (contour), ahead of or behind its place on "
        "it (along), and both together (tracking). All in µm.",
        ("", "print time", "contour RMS", "99 %", "largest", "along RMS", "largest", "tracking RMS", "travel, RMS"),
        tuple(
            (
                name,
                clock(one.time),
                _um(figures.drawn.contour.rms),
                _um(figures.drawn.contour.p99),
                _um(figures.drawn.contour.max),
                _um(figures.drawn.along.rms),
                _um(figures.drawn.along.max),
                _um(figures.drawn.tracking.rms),
                _um(figures.off.contour.rms),
            )
            for name, one in shown
            for figures in one.figures[:1]
        ),
    )


def features(shown: Named, names: Sequence[str]) -> Sheet:
    """Contour errors of each kind of line."""
    return Sheet(
        "By what is printed",
        "Distance of the nozzle from the path on each kind of line, RMS and largest, in µm.",
        ("", *(f"{name}, {what}" for name, _ in shown for what in ("RMS", "largest"))),
        tuple(
            (name, *(cell for _, one in shown for cell in _feature(one.figures[0], k)))
            for k, name in enumerate(names)
            if any(k in one.figures[0].by_feature for _, one in shown)
        ),
    )


def corners(shown: Named) -> Sheet:
    """Rounding and ringing of corners."""
    return Sheet(
        "Corners and ringing",
        "How far corners are cut short (rounding) or run over (overshoot), and the swing that stays behind them: its "
        "height and its length on the part. Median / 99 % of all corners.",
        ("", "corners", "that ring", "rounding [µm]", "overshoot [µm]", "ringing [µm]", "wavelength [mm]"),
        tuple(
            (
                name,
                f"{found.count:,}",
                f"{found.rings:,}",
                *(f"{_um(of.median)} / {_um(of.p99)}" for of in (found.rounding, found.overshoot, found.amplitude)),
                f"{found.wavelength.median:.1f}" if found.rings else "–",
            )
            for name, one in shown
            for found in (one.figures[0].corners,)
        ),
    )


def surfaces(shown: Named) -> Sheet:
    """Roughness of walls and width of beads."""
    return Sheet(
        "Surface and extrusion",
        "Roughness of the longest straight walls across X and Y (of the swing alone), and how much of the print has "
        "beads that are wider or thinner than sliced by more than 5 %: plastic flows on one clock, the nozzle moves on "
        "another.",
        ("", "wall across X, Ra [µm]", "Rz [µm]", "wall across Y, Ra [µm]", "Rz [µm]", "wider", "thinner"),
        tuple(
            (
                name,
                *(cell for axis in (0, 1) for cell in _roughness(figures, axis)),
                f"{100 * figures.bead.over_5:.1f} %",
                f"{100 * figures.bead.under_5:.1f} %",
            )
            for name, one in shown
            for figures in one.figures[:1]
        ),
    )


def mismatch(shown: Named, simulation: Simulation) -> Sheet:
    """Every method on machines that are not as modelled."""
    return Sheet(
        "If the machine is not as modelled",
        "Contour error, RMS / largest in µm, with the machine's frequencies and dampings off, every method as it was "
        "designed.",
        ("", *(condition.name for condition in simulation.conditions)),
        tuple((name, *(_pair(figures) for figures in one.figures)) for name, one in shown),
    )


def accelerations(simulation: Simulation, called: Callable[[Simulated], str]) -> Sheet:
    """Print time against error."""
    return Sheet(
        "Print time against error",
        "The same file planned with other accelerations: print time, and contour error RMS / largest in µm.",
        ("", "acceleration [mm/s²]", "print time", "contour error"),
        tuple(
            (
                called(one),
                "the file's" if one.acceleration is None else f"{one.acceleration:,.0f}",
                clock(one.time),
                _pair(one.figures[0]),
            )
            for one in simulation.results
        ),
    )


def motors(shown: Named) -> Sheet:
    """Load of the motors."""
    return Sheet(
        "Motors",
        "Highest share of the torque that a motor has left at its speed, and how far its rotor lags behind its field, "
        "at most: beyond 1 full step it falls back and steps are lost.",
        ("", "motor", "highest torque", "at line", "largest load angle [full steps]", "[µm]", "steps lost"),
        tuple(
            (
                f"{name}, {motor.name}",
                motor.motor,
                f"{100 * motor.share:.0f} %",
                str(motor.share_at.line),
                f"{motor.angle:.2f}",
                _um(motor.angle_um),
                str(sum(lost.steps for lost in one.motors.lost if lost.motor == motor.name)),
            )
            for name, one in shown
            for motor in one.motors.motors
        ),
    )


def _um(value: float) -> str:
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def _pair(figures: Accounted) -> str:
    return f"{_um(figures.drawn.contour.rms)} / {figures.drawn.contour.max:.0f}"


def _feature(figures: Accounted, k: int) -> tuple[str, str]:
    found = figures.by_feature.get(k)
    return ("–", "–") if found is None else (_um(found.contour.rms), f"{found.contour.max:.0f}")


def _roughness(figures: Accounted, axis: int) -> tuple[str, str]:
    wall = next((wall for wall in figures.walls if wall.axis == axis), None)
    return ("–", "–") if wall is None else (_um(wall.roughness["Ra"]), _um(wall.roughness["Rz"]))
