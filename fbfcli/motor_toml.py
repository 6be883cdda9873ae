"""What a profile says of its motors: [axis.x.motor], in the units of data sheets, and [axis.x.load]."""

from __future__ import annotations

from math import inf

from fbfcli.printer import Axis, Load, Motor
from fbfcli.toml_table import Table

FULL_STEPS = (200.0, 400.0)  # of hybrid steppers: 1.8 and 0.9 degrees
MICROSTEPS = tuple(float(2**k) for k in range(9))
HENRY_PER_MH = 1e-3
KG_M2_PER_G_CM2 = 1e-7
N_S_PER_MM_PER_N_S_PER_M = 1e-3
RATED = 1.5  # times the rated current: no drive is set higher, somebody meant mA
CONTRADICTION = 0.01  # steps_per_mm is calibrated on parts: it may differ this much from what pulley and drive give
COUPLED = {"cartesian": ("",), "corexy": ("XY",), "delta": ("XYZ",)}  # axes that motors move together


def motor(axis: Table, steps_per_mm: float) -> Motor:
    """[axis.x.motor]. Raises ProfileError, also where steps_per_mm and what motor and pulley give contradict."""
    table = axis.table("motor").only(
        "name", "full_steps", "holding_torque", "rated_current", "resistance", "inductance_mh", "rotor_inertia_gcm2",
        "detent_torque", "damping", "supply_voltage", "run_current", "microsteps", "interpolation", "mm_per_turn")
    full_steps = _one_of(table, "full_steps", FULL_STEPS, 200.0)
    microsteps = _one_of(table, "microsteps", MICROSTEPS, 16.0)
    mm_per_turn = table.number("mm_per_turn", full_steps * microsteps / steps_per_mm)
    wanted = full_steps * microsteps / mm_per_turn
    if abs(wanted / steps_per_mm - 1.0) > CONTRADICTION:
        table.refuse("mm_per_turn", f"{full_steps:g} full steps of {microsteps:g} microsteps on {mm_per_turn:g} mm are "
                     f"{wanted:g} steps per mm, not steps_per_mm = {steps_per_mm:g}",
                     f"mm_per_turn = {full_steps * microsteps / steps_per_mm:g} with these microsteps")  # fmt: skip
    rated = table.number("rated_current", below=20.0)
    torque = table.number("holding_torque", below=20.0)
    run = table.number("run_current", rated, below=RATED * rated)
    return Motor(
        name=table.text("name", "not stated"),
        full_steps=int(full_steps),
        holding_torque=torque,
        rated_current=rated,
        resistance=table.number("resistance", below=100.0),
        inductance=table.number("inductance_mh", below=200.0) * HENRY_PER_MH,
        rotor_inertia=table.number("rotor_inertia_gcm2", below=10_000.0) * KG_M2_PER_G_CM2,
        supply_voltage=table.number("supply_voltage", below=200.0),
        run_current=run,
        microsteps=int(microsteps),
        mm_per_turn=mm_per_turn,
        detent_torque=table.number("detent_torque", 0.0, above=-inf, least=0.0, below=0.5 * torque * run / rated),
        damping=table.number("damping", Motor.damping, above=-inf, least=0.0, below=1.0),
        interpolation=_yes(table, "interpolation"),
    )


def load(axis: Table) -> Load:
    """[axis.x.load]. Raises ProfileError."""
    table = axis.table("load").only("mass", "friction", "viscous")
    return Load(
        mass=table.number("mass", below=100.0),
        friction=table.number("friction", 0.0, above=-inf, least=0.0, below=1000.0),
        viscous=table.number("viscous", 0.0, above=-inf, least=0.0, below=1000.0) * N_S_PER_MM_PER_N_S_PER_M,
    )


def check_motors(axes: Table, built: tuple[Axis, ...], kinematics: str) -> None:
    """Refuse motors whose load nobody has said: what moves along each of the axes that they move."""
    for axis in built:
        if axis.motor is None:
            continue
        together = next((names for names in COUPLED[kinematics] if axis.name in names), axis.name)
        for other in built:
            if other.name in together and other.load is None:
                axes.table(other.name.lower()).need("load", f"mass = <kg> under [axis.{other.name.lower()}.load]: the "
                                                    f"motor of {axis.name} moves it")  # fmt: skip


def _one_of(table: Table, key: str, choices: tuple[float, ...], usual: float) -> float:
    value = table.number(key, usual)
    if value not in choices:
        table.refuse(key, "is not known", f"one of {', '.join(f'{choice:g}' for choice in choices)}")
    return value


def _yes(table: Table, key: str) -> bool:
    value = table.values.get(key, False)
    if not isinstance(value, bool):
        table.refuse(key, "must be true or false")
    return value
