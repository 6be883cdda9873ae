"""A printer: its firmware, limits, axes and models. Profiles are read by `printer_toml`."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan

FIRMWARES = ("klipper", "marlin", "reprapfirmware")
KINEMATICS = ("cartesian", "corexy", "delta")
COORDINATES = ("x", "y", "z", "mass")  # that a place is told by
WIDEST = 10.0  # factor of an uncertainty: further from 1 it is no uncertainty but another machine

Four = tuple[float, float, float, float]


@dataclass(frozen=True)
class Limits:
    """What the planner allows, in force at some line of a file. Units mm, s.

    Klipper reads `velocity`, `acceleration`, `square_corner_velocity`, `minimum_cruise_ratio`, the Z and E entries of
    `axis_velocity` and `axis_acceleration`, and the E entry of `jerk` (instantaneous_corner_velocity).
    Marlin and RepRapFirmware read the rest; Marlin uses classic jerk where `junction_deviation` is nan.
    """

    velocity: float = inf
    acceleration: float = 3000.0  # extruding moves (M204 P); Klipper's max_accel for every move
    travel_acceleration: float = 3000.0  # M204 T
    retract_acceleration: float = 3000.0  # M204 R, moves of E alone
    axis_velocity: Four = (inf, inf, inf, inf)  # M203, X Y Z E
    axis_acceleration: Four = (inf, inf, inf, inf)  # M201
    jerk: Four = (inf, inf, inf, inf)  # M205 X Y Z E, M566
    junction_deviation: float = nan  # M205 J
    square_corner_velocity: float = 5.0
    minimum_cruise_ratio: float = 0.5


@dataclass(frozen=True)
class Mode:
    """One vibration mode: gain * w^2 / (s^2 + 2 damping w s + w^2), w = 2 pi frequency [Hz]."""

    frequency: float
    damping: float
    gain: float = 1.0


@dataclass(frozen=True)
class ModalModel:
    """A sum of modes; the gains sum to one (position follows the command at rest)."""

    modes: tuple[Mode, ...]


@dataclass(frozen=True)
class TransferFunction:
    """Discrete transfer function b(z^-1) / a(z^-1) at period `dt` [s]."""

    b: tuple[float, ...]
    a: tuple[float, ...]
    dt: float


@dataclass(frozen=True)
class ImpulseResponse:
    """Finite impulse response `h` at period `dt` [s], read from a CSV named in the profile."""

    h: tuple[float, ...]
    dt: float


@dataclass(frozen=True)
class FrequencyResponse:
    """Complex response at `frequency` [Hz]: `magnitude` [1] and `phase` [rad]."""

    frequency: tuple[float, ...]
    magnitude: tuple[float, ...]
    phase: tuple[float, ...]


Model = ModalModel | TransferFunction | ImpulseResponse | FrequencyResponse


@dataclass(frozen=True)
class Spread:
    """How far an axis may be from its model: factors on its frequencies and dampings, lowest and highest."""

    frequency: tuple[float, float] = (1.0, 1.0)
    damping: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class Family:
    """The models that an axis may really have, and the probability of each; `weights` sum to 1."""

    models: tuple[Model, ...]
    weights: tuple[float, ...]


@dataclass(frozen=True)
class Place:
    """A model, and the position [mm] and the printed mass [kg] that it was measured at; None where it is not said."""

    model: Model
    x: float | None = None
    y: float | None = None
    z: float | None = None
    mass: float | None = None


@dataclass(frozen=True)
class Motor:
    """A hybrid stepper, its drive, and the belt or screw on its shaft.

    name           : for people
    full_steps     : of one turn
    holding_torque : both phases at the rated current [N m]
    rated_current  : of a phase [A]
    resistance, inductance : of a phase [ohm, H]
    rotor_inertia  : [kg m^2]
    supply_voltage : of the drive [V]
    run_current    : of a phase, RMS [A]
    microsteps     : of a full step
    mm_per_turn    : how far the axis goes in one turn of the shaft [mm]
    detent_torque  : without current [N m]
    damping        : damping ratio of the rotor's own oscillation
    interpolation  : the drive makes 256 microsteps of every full step, whatever it is sent
    """

    name: str
    full_steps: int
    holding_torque: float
    rated_current: float
    resistance: float
    inductance: float
    rotor_inertia: float
    supply_voltage: float
    run_current: float
    microsteps: int
    mm_per_turn: float
    detent_torque: float = 0.0
    damping: float = 0.05
    interpolation: bool = False


@dataclass(frozen=True)
class Load:
    """What moving along an axis costs: mass [kg], dry friction [N], and friction that grows with speed [N s/mm]."""

    mass: float
    friction: float = 0.0
    viscous: float = 0.0


@dataclass(frozen=True)
class Axis:
    """One linear axis of the tool. `model` is None for an axis that is not compensated (Z).

    travel                : lowest and highest position the machine can reach [mm]
    steps_per_mm          : of the motor
    command_velocity      : highest speed a compensated command may have [mm/s]
    command_acceleration  : highest acceleration a compensated command may have [mm/s^2]
    uncertainty           : how far the axis may be from its model; None: nobody has said
    at                    : models at several places, all told by the same coordinates; the model changes between them
    coupling              : what the command of the other of X and Y adds to the position; it stands where that one does
    motor                 : the one that steps_per_mm is of; None: nobody has said
    load                  : of what moves along the axis; there if a motor is
    """

    name: str
    travel: tuple[float, float]
    steps_per_mm: float
    command_velocity: float = inf
    command_acceleration: float = inf
    model: Model | None = None
    uncertainty: Spread | Family | None = None
    at: tuple[Place, ...] = ()
    coupling: ModalModel | TransferFunction | None = None
    motor: Motor | None = None
    load: Load | None = None


@dataclass(frozen=True)
class Driver:
    """What a stepper driver wants of its inputs; the defaults suit the slowest of the usual ones.

    step_pulse      : shortest pulse, and shortest pause between two [s]
    direction_setup : the direction must stand this long before a step [s]
    max_step_rate   : [steps/s]
    hysteresis      : a position must come back this far before a step is taken back [steps]
    """

    step_pulse: float = 1.9e-6  # DRV8825, Table 7.6: 1.9 us high, 1.9 us low; A4988 1 us, TMC2209 0.1 us
    direction_setup: float = 0.65e-6  # DRV8825: 650 ns; A4988 200 ns, TMC2209 20 ns
    max_step_rate: float = 250e3  # DRV8825; A4988 500 kHz
    hysteresis: float = 1e-4  # far above rounding (1e-7), far below a microstep


@dataclass(frozen=True)
class Printer:
    """Everything fbf knows of a machine. `axes` are X, Y, Z in this order."""

    name: str
    source: str  # where the numbers come from, for people
    firmware: str
    kinematics: str
    axes: tuple[Axis, Axis, Axis]
    limits: Limits  # in force at power-on
    segments_per_second: float  # what the firmware can take
    nozzle_diameter: float = 0.4
    max_extrude_cross_section: float = inf  # Klipper refuses thicker lines [mm^2]
    filament_diameter: float = 1.75
    e_steps_per_mm: float | None = None  # of filament; None: E makes no steps
    delta_radius: float | None = None  # [mm]
    arm_length: float | None = None  # of a delta [mm]
    driver: Driver = Driver()
    filament_density: float = 1.24e-6  # kg/mm^3, PLA
