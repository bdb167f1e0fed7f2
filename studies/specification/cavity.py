"""How the cavity of a particle lies and what it is made of: what acts on the particle between impacts."""

from dataclasses import dataclass
from math import cos, pi, radians, sin

from damperlab.studies.physical import STANDARD_GRAVITY


@dataclass(frozen=True)
class Cavity:
    """The cavity of a damper.

    Parameters
    ----------
    particle_friction_coefficient : float
        μ_i of sliding friction between particle and cavity.
    tilt_deg : float
        α: 0 lies, 90 stands.
    """

    particle_friction_coefficient: float = 0.0
    tilt_deg: float = 0.0

    @property
    def acts(self) -> bool:
        """Whether anything acts on the particle between impacts."""
        return self.particle_friction_coefficient > 0.0 or self.tilt_deg > 0.0

    def ratios(self, natural_frequency_hz: float, base_amplitude_m: float) -> tuple[float, float]:
        """Give κ and G under a base amplitude, or a static displacement."""
        weight = STANDARD_GRAVITY / ((2.0 * pi * natural_frequency_hz) ** 2 * base_amplitude_m)
        lying = 0.0 if self.tilt_deg == 90.0 else cos(radians(self.tilt_deg))
        friction = self.particle_friction_coefficient * weight * lying
        return friction, weight * sin(radians(self.tilt_deg))


LEVEL = Cavity()
"""One that lies level, in which the particle slides freely."""
