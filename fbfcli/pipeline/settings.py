"""What a user may set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

TOLERANCE_MM = 5e-3
DT_S = 1e-3
AUTO = "auto"  # the method that pipeline.choice gives
AS_WRITTEN = "none"  # the method that changes nothing: the firmware's own plan


@dataclass(frozen=True)
class Settings:
    """How a file is compensated.

    method      : a name of control.design.METHODS, or AUTO
    tolerance   : of a written chord from the command [mm]
    dt          : period of the trajectory [s]
    acceleration, velocity : planned instead of what the profile and the file say [mm/s^2], [mm/s]; None: theirs
    segments_per_second    : what the firmware can take; None: the profile's
    options     : of the method (control.design)
    spread      : how far frequencies may be from the models', as a part of them; None: as the profile says
    with_nozzle : filament in step with where the nozzle is expected, not with the desired motion; None: for
                  methods that let the nozzle run ahead or behind
    fir         : samples of the impulse response the method knows; None: until it has died out
    shaped      : frequencies of X and Y that a shaper is made for [Hz]; None: those of their strongest modes
    patch_times : time comments and M73 are written padded, to be filled in at the end
    """

    method: str = AUTO
    tolerance: float = TOLERANCE_MM
    dt: float = DT_S
    acceleration: float | None = None
    velocity: float | None = None
    segments_per_second: float | None = None
    options: Mapping[str, float] = field(default_factory=dict)
    spread: float | None = None
    with_nozzle: bool | None = None
    fir: int | None = None
    shaped: tuple[float, float] | None = None
    patch_times: bool = True

    def told(self, method: str) -> str:
        """The settings on one line, for the stamp; `method` is the one that was taken."""
        parts = [f"method={method}", f"tolerance={1e3 * self.tolerance:g}um"]
        if self.acceleration is not None:
            parts.append(f"accel={self.acceleration:g}")
        if self.velocity is not None:
            parts.append(f"velocity={self.velocity:g}")
        if self.spread is not None:
            parts.append(f"spread={self.spread:g}")
        if self.with_nozzle is not None:
            parts.append(f"extrusion={'nozzle' if self.with_nozzle else 'plan'}")
        if self.fir is not None:
            parts.append(f"fir={self.fir}")
        if self.shaped is not None:
            parts.append("shaped=" + ",".join(f"{f:.4g}Hz" for f in self.shaped))
        parts += [f"{name}={value:g}" for name, value in sorted(self.options.items())]
        return " ".join(parts)
