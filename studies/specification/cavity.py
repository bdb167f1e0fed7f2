"""How the cavity of a particle lies and what it is made of: what acts on the particle between impacts."""

from dataclasses import dataclass

import numpy as np

from damperlab.studies.physical import DERIVATIONS
from damperlab.studies.variables import BEFORE


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
        given = {
            "natural_frequency_hz": natural_frequency_hz,
            "base_amplitude_m": base_amplitude_m,
            "particle_friction_coefficient": self.particle_friction_coefficient,
            "tilt_deg": self.tilt_deg,
        }
        of = {name: np.array([value]) for name, value in given.items()}
        friction, gravity = (float(DERIVATIONS[name].values(of)[0]) for name in BEFORE)
        return friction, gravity


LEVEL = Cavity()
"""One that lies level, in which the particle slides freely."""
