"""The cavity of a particle, its tilt and friction: the forces on the particle between impacts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from damperlab.studies.physical import DERIVATIONS
from damperlab.studies.quantity import OF_CAVITY
from damperlab.studies.variables import BEFORE, GRAVITY, MADE_BY, PARTICLE_FRICTION


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
        """The numbers of a document by name, in the order of `BEFORE`."""
        return {name: getattr(self, name) for name in MADE_BY.values()}

    @property
    def words(self) -> str:
        """Its tilt and friction in words."""
        lies = f"tilted by {self.tilt_deg:.3g}°" if self.tilt_deg else "lying"
        coefficient = self.particle_friction_coefficient
        return f"{lies}, {f'μ_i = {coefficient:.3g}' if coefficient else 'frictionless'}"

    @property
    def acts(self) -> bool:
        """Whether friction or gravity acts on the particle between impacts."""
        return any(self.numbers.values())

    def ratio(self, name: str, case: Mapping[str, float]) -> float:
        """Give one ratio of `BEFORE` in a physical case.

        Parameters
        ----------
        name : str
            The ratio.
        case : mapping of float
            The quantities of a physical block, apart from those of the cavity, that determine it together with the
            cavity; `base_amplitude_m` may be a static displacement.
        """
        of = {quantity: np.array([value]) for quantity, value in {**case, **self.numbers}.items()}
        return float(DERIVATIONS[name].values(of)[0])

    def ratios(self, case: Mapping[str, float]) -> tuple[float, ...]:
        """Give every ratio of `BEFORE`, in this order, in a physical case, see `ratio`."""
        return tuple(self.ratio(name, case) for name in BEFORE)


FRICTIONLESS = "frictionless"
_ASSUMED = {GRAVITY: "lying", PARTICLE_FRICTION: FRICTIONLESS}
LEVEL = Cavity()
"""The default: level, and without friction."""


def left_open(definition: Mapping[str, Any]) -> list[str]:
    """Describe the properties of the cavity that a definition leaves at their defaults."""
    given = {**definition, **(definition.get("axes") or {})}
    physical = definition.get("physical") or {}
    return [
        words
        for name, words in _ASSUMED.items()
        if given.get(name) is None and physical.get(MADE_BY[name]) is None
    ]


def cavity_of(values: Mapping[str, float | None]) -> Cavity:
    """Give the cavity of a document's numbers.

    A missing number is 0. A number that exceeds its bound only because a tolerance was rounded is set to the bound.
    """
    return Cavity(*(min(values.get(each.name) or 0.0, each.highest) for each in OF_CAVITY))
