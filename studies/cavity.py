"""How the cavity of a particle lies and what it is made of: what acts on the particle between impacts."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from damperlab.studies.physical import DERIVATIONS
from damperlab.studies.quantity import OF_CAVITY
from damperlab.studies.variables import BEFORE, MADE_BY


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
    def numbers(self) -> dict[str, float]:
        """What a document writes, by name, in the order of `BEFORE`."""
        return {name: getattr(self, name) for name in MADE_BY.values()}

    @property
    def words(self) -> str:
        """How it lies and rubs."""
        lies = f"tilted by {self.tilt_deg:.3g}°" if self.tilt_deg else "lying"
        coefficient = self.particle_friction_coefficient
        return f"{lies}, {f'μ_i = {coefficient:.3g}' if coefficient else 'frictionless'}"

    @property
    def acts(self) -> bool:
        """Whether anything acts on the particle between impacts."""
        return any(self.numbers.values())

    def ratios(self, natural_frequency_hz: float, base_amplitude_m: float) -> tuple[float, ...]:
        """Give κ and G, in the order of `BEFORE`, under a base amplitude, or a static displacement."""
        given = self.numbers | {
            "natural_frequency_hz": natural_frequency_hz,
            "base_amplitude_m": base_amplitude_m,
        }
        of = {name: np.array([value]) for name, value in given.items()}
        return tuple(float(DERIVATIONS[name].values(of)[0]) for name in BEFORE)


LEVEL = Cavity()
"""One that lies level, in which the particle slides freely."""


def cavity_of(values: Mapping[str, float | None]) -> Cavity:
    """Give the cavity of a document's numbers.

    A number that is missing is 0. One beyond its bound, by a tolerance's rounding, is the bound.
    """
    return Cavity(*(min(values.get(each.name) or 0.0, each.highest) for each in OF_CAVITY))
