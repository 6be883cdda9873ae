"""How the command is computed: the options of every verb that compensates, and the settings they make."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fbfcli.cli.options import Number, Numbers, spread_option, velocity_option
from fbfcli.units import UM_PER_MM

if TYPE_CHECKING:
    from fbfcli.pipeline import Settings

METHODS = (
    "auto",
    "none",
    "zv",
    "mzv",
    "zvd",
    "ei",
    "2hump_ei",
    "3hump_ei",
    "lpfbs",
    "fbf",
    "robust",
    "robust_fbf",
    "contour",
    "npz_ignore",
    "zpetc",
    "zmetc",
    "ebzpetc",
    "ts",
    "stable_inversion",
)  # as control.design, without importing numpy
INVERSION_METHODS = METHODS[METHODS.index("npz_ignore") :]
SPLINE_METHODS = ("auto", "lpfbs", "fbf", "robust", "robust_fbf", "contour")
PREVIEW_METHODS = ("auto", "lpfbs", "robust", "contour", "stable_inversion")
SHAPERS = METHODS[METHODS.index("zv") : METHODS.index("lpfbs")]
FIR_METHODS = ("lpfbs", "fbf")  # whose impulse response may be cut: the others cut theirs by their own rule
FAMILY_METHODS = ("auto", "robust", "robust_fbf", "contour")
ONLY_FOR = (  # options that mean nothing to other methods
    ({"knots", "degree", "mu", "settle"}, SPLINE_METHODS),
    ({"preview"}, PREVIEW_METHODS),
    ({"fir"}, FIR_METHODS),
    ({"shaped"}, SHAPERS),
    ({"spread"}, FAMILY_METHODS),
    ({"terms"}, ("ebzpetc", "ts")),
    ({"smooth", "zero_damping"}, INVERSION_METHODS),
)
OPTION_NAMES = (
    ("smooth", "smooth"),
    ("knots", "L"),
    ("preview", "preview"),
    ("settle", "lead"),
    ("settle", "tail"),
)  # as control.design has them
MS_PER_S = 1e3
PERCENT = 100.0

Verb = TypeVar("Verb", bound=Callable[..., Any])

_OPTIONS = (
    click.option(
        "-m",
        "--method",
        type=click.Choice(METHODS),
        default="auto",
        show_default="auto: by a rule, told in the summary",
        help="How the command is computed.",
    ),
    spread_option,
    click.option(
        "--extrusion",
        type=click.Choice(("nozzle", "plan")),
        help="Filament in step with the expected nozzle, or with the plan. "
        "[default: nozzle for robust, robust_fbf, contour]",
    ),
    click.option(
        "--accel",
        type=Number(min=0, min_open=True),
        metavar="MM/S2",
        help="Plan with this acceleration instead of the file's.",
    ),
    velocity_option,
    click.option(
        "--shaped",
        type=Numbers(),
        metavar="HZ,HZ",
        help="Shapers: frequencies of X and Y that they are made for. [default: those of the strongest modes]",
    ),
    click.option("--knots", type=click.IntRange(1, 200), metavar="MS", help="Splines: spacing of their knots."),
    click.option("--degree", type=click.IntRange(2, 9), metavar="M", help="Splines: their degree."),
    click.option("--mu", type=Number(min=0), metavar="WEIGHT", help="Splines: weight on the command's curvature."),
    click.option(
        "--preview",
        type=click.IntRange(10, 5000),
        metavar="MS",
        help="lpfbs, robust, contour, stable_inversion: how far the method looks ahead.",
    ),
    click.option(
        "--fir", type=click.IntRange(10, 20000), metavar="MS", help="lpfbs, fbf: length of the impulse response."
    ),
    click.option(
        "--settle",
        type=click.IntRange(0, 1000),
        metavar="MS",
        help="Splines: rest kept before and after each stretch of motion.",
    ),
    click.option(
        "--terms", type=click.IntRange(1, 1000), metavar="N", help="ts, ebzpetc: terms of the series. [default: 5]"
    ),
    click.option(
        "--zero-damping",
        type=Number(0, 1),
        metavar="ZETA",
        help="Inverses: zeros damped less are not cancelled. [default: 0.02]",
    ),
    click.option(
        "--smooth",
        type=click.IntRange(0, 100),
        metavar="MS",
        help="Inverses: knots of the spline that smooths the command; 0 for none. [default: 4]",
    ),
)


def method_options(verb: Verb) -> Verb:
    """Gives a verb these options; it takes them as **how, for `settings_of`."""
    return reduce(lambda decorated, option: option(decorated), reversed(_OPTIONS), verb)


def settings_of(how: dict[str, Any], patch_times: bool) -> Settings:
    """The settings that options ask for. Raises UsageError for one that means nothing to the method."""
    from fbfcli.pipeline import Settings

    given = {name: value for name, value in how.items() if value is not None}
    for own, methods in ONLY_FOR:
        if given["method"] not in methods and (idle := sorted(given.keys() & own)):
            option = idle[0].replace("_", "-")
            raise click.UsageError(f"--{option} is for {', '.join(methods)}, not for {given['method']}")
    samples = {
        name: round(given[name] / MS_PER_S / Settings.dt)
        for name in ("knots", "preview", "settle", "fir", "smooth")
        if name in given
    }
    options: dict[str, float] = {
        name: float(given[name]) for name in ("degree", "mu", "terms", "zero_damping") if name in given
    }
    options |= {name: samples[option] for option, name in OPTION_NAMES if option in samples}
    return Settings(
        method=given["method"],
        tolerance=given.get("tolerance", UM_PER_MM * Settings.tolerance) / UM_PER_MM,
        acceleration=given.get("accel"),
        velocity=given.get("velocity"),
        segments_per_second=given.get("segments"),
        options=options,
        spread=given["spread"] / PERCENT if "spread" in given else None,
        with_nozzle=given["extrusion"] == "nozzle" if "extrusion" in given else None,
        fir=samples.get("fir"),
        shaped=_two(given["shaped"]) if "shaped" in given else None,
        patch_times=patch_times,
    )


def _two(frequencies: tuple[float, ...]) -> tuple[float, float]:
    """One for both axes, or one each. Raises UsageError."""
    if len(frequencies) > 2:
        raise click.UsageError("--shaped takes one frequency, or those of X and Y")
    return frequencies[0], frequencies[-1]
