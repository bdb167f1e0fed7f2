"""The cavity of a particle. Tilt and friction of the cavity cause forces on the particle between impacts."""

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
        Coefficient μ_i of sliding friction between particle and cavity.
    tilt_deg : float
        Tilt α [°] of the cavity: 0 for a horizontal cavity, 90 for a vertical one.
    """

    particle_friction_coefficient: float = 0.0
    tilt_deg: float = 0.0

    @property
    def numbers(self) -> dict[str, float]:
        """Friction coefficient and tilt by field name, in the order of `BEFORE`."""
        return {name: getattr(self, name) for name in MADE_BY.values()}

    @property
    def words(self) -> str:
        """Tilt and friction of the cavity in words."""
        lies = f"tilted by {self.tilt_deg:.3g}°" if self.tilt_deg else "lying"
        coefficient = self.particle_friction_coefficient
        return f"{lies}, {f'μ_i = {coefficient:.3g}' if coefficient else 'frictionless'}"

    @property
    def acts(self) -> bool:
        """Whether friction or gravity acts on the particle between impacts."""
        return any(self.numbers.values())

    def ratio(self, name: str, case: Mapping[str, float]) -> float:
        """Return a ratio of the cavity, one of the names in `BEFORE`, for a physical case.

        Parameters
        ----------
        name : str
            Name of the ratio.
        case : mapping of float
            Quantities of a physical block that determine the ratio together with the cavity. If a
            force excites the structure, `base_amplitude_m` is the static displacement.
        """
        of = {quantity: np.array([value]) for quantity, value in {**case, **self.numbers}.items()}
        return float(DERIVATIONS[name].values(of)[0])

    def ratios(self, case: Mapping[str, float]) -> tuple[float, ...]:
        """Return the ratios of `BEFORE`, in this order, for a physical case; see `ratio`."""
        return tuple(self.ratio(name, case) for name in BEFORE)


FRICTIONLESS = "frictionless"
_ASSUMED = {GRAVITY: "lying", PARTICLE_FRICTION: FRICTIONLESS}
LEVEL = Cavity()
"""The default cavity: horizontal, and without friction."""


def left_open(definition: Mapping[str, Any]) -> list[str]:
    """Describe the properties of the cavity that a definition does not contain."""
    given = {**definition, **(definition.get("axes") or {})}
    physical = definition.get("physical") or {}
    return [
        words
        for name, words in _ASSUMED.items()
        if given.get(name) is None and physical.get(MADE_BY[name]) is None
    ]


def cavity_of(values: Mapping[str, float | None]) -> Cavity:
    """Make the cavity from the friction coefficient and the tilt in a document.

    A missing coefficient or tilt is 0. A number above its bound, for example after rounding, is replaced by
    the bound.
    """
    return Cavity(*(min(values.get(each.name) or 0.0, each.highest) for each in OF_CAVITY))
