"""A damper on a structure, with nominal values or with deviations within the tolerances."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

from damperlab.studies.cavity import LEVEL, Cavity, cavity_of
from damperlab.studies.shapes import Says
from damperlab.studies.specification.excitation import Amplitude, Case, Under
from damperlab.studies.specification.measure import DAMPER_LIMITS, DamperLimit
from damperlab.studies.specification.specification import (
    CHOSEN,
    OF_DAMPER,
    OF_STRUCTURE,
    RATIO_OF,
    Specification,
    Structure,
)
from damperlab.studies.variables import BEFORE

Place = tuple[float, float, float, float, float]
"""ζ, e, β, d/Z and γ_F; without a particle e, β and d/Z are 0."""

Law = tuple[()] | tuple[str] | tuple[str, float, float, float]
"""The constant quantity of the excitation. The tuple is empty for a base displacement, and contains "force" for a
force. For a base velocity or acceleration, the tuple contains the name of the quantity, the base amplitude Z at the
natural frequency, and the structure's mass and natural frequency. For a record, the tuple contains id and
scale of the record instead of the name and Z.
"""
FORCE = ("force",)
Inside = tuple[float, ...]
"""Parameters of the forces on a particle: the contact time relative to 1/ω_n (0 if contacts take no time), and the
ratios in `BEFORE`. Under a record, and under a constant velocity or acceleration of the base, the numbers of
the `Cavity` replace the ratios in `BEFORE`.
"""
NOTHING_INSIDE: Inside = (0.0,) * (1 + len(BEFORE))
Spot = tuple[Law, Place, Inside]
"""Parameters of a damper under an amplitude. For a constant displacement or force, all parameters are ratios.
For a base velocity or acceleration, and for a record, d [m] and F_f [N] replace d/Z and γ_F. For a record,
m [kg] also replaces β.
"""


@dataclass(frozen=True)
class Build:
    """One damper on one structure.

    Parameters
    ----------
    clearance_m, friction_force_n, particle_mass_kg, restitution : float
        Quantities of the damper; a mass of 0 means that there is no particle.
    mass_off, frequency_off, damping_off : float
        Relative deviations of the structure: 0.01 is one per cent above nominal.
    contact_time_s : float
        Contact time; 0 if impacts take no time.
    cavity : Cavity
        Tilt of the cavity, and friction between particle and cavity.
    """

    clearance_m: float
    friction_force_n: float
    particle_mass_kg: float
    restitution: float
    mass_off: float = 0.0
    frequency_off: float = 0.0
    damping_off: float = 0.0
    contact_time_s: float = 0.0
    cavity: Cavity = LEVEL

    def place(self, structure: Structure, amplitude_m: float) -> Place:
        """Return the ratios of this build under a base amplitude or a static displacement."""
        mass = structure.mass_kg * (1.0 + self.mass_off)
        stiffness = mass * (structure.angular_frequency * (1.0 + self.frequency_off)) ** 2
        damping = min(structure.damping_ratio * (1.0 + self.damping_off), 0.999)
        friction = self.friction_force_n / (stiffness * amplitude_m)
        if self.particle_mass_kg == 0.0:
            return (damping, 0.0, 0.0, 0.0, friction)
        clearance = self.clearance_m / amplitude_m
        return (damping, self.restitution, self.particle_mass_kg / mass, clearance, friction)

    def spot(self, structure: Structure, amplitude: Under) -> Spot:
        """Return the parameters that a study needs for this build under an amplitude or a record, for any frequency."""
        if isinstance(amplitude, Case):
            return self._under_record(structure, amplitude)
        ratios = self.place(structure, self._reference_m(amplitude))
        constant = amplitude.excitation.motion.constant
        if constant is None:
            inside = self._inside(structure, self._reference_m(amplitude))
            return FORCE if amplitude.excitation.motion.force else (), ratios, inside
        mass = structure.mass_kg * (1.0 + self.mass_off)
        frequency = structure.natural_frequency_hz * (1.0 + self.frequency_off)
        law = (constant, amplitude.base_m(self.nominal(1.0)), mass, frequency)
        clearance = self.clearance_m if self.particle_mass_kg else 0.0
        return law, (*ratios[:3], clearance, self.friction_force_n), self._numbers_inside(structure)

    def _reference_m(self, amplitude: Amplitude) -> float:
        """Return the base amplitude at the nominal natural frequency, or the static displacement of this structure."""
        if not amplitude.excitation.motion.force:
            return amplitude.reference_m
        return amplitude.reference_m / ((1.0 + self.mass_off) * (1.0 + self.frequency_off) ** 2)

    def base_m(self, amplitude: Amplitude, frequency_ratio: float) -> float:
        """Return the base amplitude Z [m], or the static displacement, at a frequency ratio of this structure."""
        return amplitude.excitation.base_m(self._reference_m(amplitude), self.nominal(frequency_ratio))

    def rate(self, asked: Specification) -> float:
        """Return ω_n of this structure [rad/s], or relative to the nominal ω_n for a specification in ratios."""
        nominal = asked.structure.angular_frequency if asked.in_units else 1.0
        return nominal * (1.0 + self.frequency_off)

    def _inside(self, structure: Structure, amplitude_m: float) -> Inside:
        """Return the parameters of the forces on the particle as ratios, under a base amplitude."""
        if self.particle_mass_kg == 0.0:
            return NOTHING_INSIDE
        if not self.cavity.acts:
            return (self._contact_time(structure), *NOTHING_INSIDE[1:])
        case = {
            "mass_kg": structure.mass_kg * (1.0 + self.mass_off),
            "natural_frequency_hz": structure.natural_frequency_hz * (1.0 + self.frequency_off),
            "base_amplitude_m": amplitude_m,
            "particle_mass_kg": self.particle_mass_kg,
        }
        return (self._contact_time(structure), *self.cavity.ratios(case))

    def _numbers_inside(self, structure: Structure) -> Inside:
        """Return the contact time times ω_n, the friction coefficient and the tilt; zeros without a particle."""
        if self.particle_mass_kg == 0.0:
            return NOTHING_INSIDE
        return (self._contact_time(structure), *self.cavity.numbers.values())

    def _contact_time(self, structure: Structure) -> float:
        return self.contact_time_s * structure.angular_frequency * (1.0 + self.frequency_off)

    def _under_record(self, structure: Structure, case: Case) -> Spot:
        mass = structure.mass_kg * (1.0 + self.mass_off)
        frequency = structure.natural_frequency_hz * (1.0 + self.frequency_off)
        damping = min(structure.damping_ratio * (1.0 + self.damping_off), 0.999)
        law = (case.source.id, case.scale, mass, frequency)
        if self.particle_mass_kg == 0.0:
            return law, (damping, 0.0, 0.0, 0.0, self.friction_force_n), NOTHING_INSIDE
        damper = (self.restitution, self.particle_mass_kg, self.clearance_m, self.friction_force_n)
        return law, (damping, *damper), self._numbers_inside(structure)

    def limited(self, about: DamperLimit) -> float:
        """Return the quantity that a limit on the damper restricts; 0 for an absent particle."""
        if self.particle_mass_kg == 0.0 and about.quantity != "friction_force_n":
            return 0.0
        return about.factor * float(getattr(self, about.quantity))

    def as_built(self, asked: Specification, about: DamperLimit) -> float:
        """Return the quantity that a limit on the damper restricts, at the upper end of the tolerance."""
        upper = {about.quantity: 1.0} if about.quantity in asked.tolerances else {}
        return self.moved(asked, upper).limited(about)

    def excess(self, asked: Specification) -> float:
        """Return the largest relative excess over the limits on the damper; 0 if the damper keeps these limits."""
        own = {DAMPER_LIMITS[name]: limit for name, limit in asked.damper_limits.items()}
        return max((about.excess(self.limited(about), limit) for about, limit in own.items()), default=0.0)

    def own(self, frequency_ratio: float) -> float:
        """Convert a ratio to the nominal natural frequency into a ratio to the natural frequency of this structure."""
        return frequency_ratio / (1.0 + self.frequency_off)

    def nominal(self, frequency_ratio: float) -> float:
        """Convert a ratio to the natural frequency of this structure into a ratio to the nominal natural frequency."""
        return frequency_ratio * (1.0 + self.frequency_off)

    def moved(self, asked: Specification, shares: dict[str, float]) -> "Build":
        """Return this build with deviations, given as fractions of the tolerances from −1 to 1."""
        changed: dict[str, float] = {}
        structure: dict[str, float] = {}
        for name, share in shares.items():
            tolerance = asked.tolerances[name]
            if name not in OF_DAMPER:
                structure[name] = share * tolerance.size
                continue
            value = self.value(name)
            if name == "particle_mass_kg" and not value:
                continue  # an absent particle has no tolerance
            changed[name] = max(value + share * tolerance.of(value), 0.0)
            if name == "restitution":
                changed[name] = min(changed[name], 1.0)
        if structure:
            mass, *others = (structure.get(name, 0.0) for name in OF_STRUCTURE)
            frequency, damping = asked.structure.built_off(mass, *others)
            changed |= {"mass_off": mass, "frequency_off": float(frequency), "damping_off": float(damping)}
        return self.with_values(changed)

    def value(self, name: str) -> float:
        """Return a quantity of the damper by its name in `OF_DAMPER`."""
        return float(getattr(self if name in CHOSEN else self.cavity, name))

    def with_values(self, values: Mapping[str, float]) -> "Build":
        """Return this build with other values of some quantities."""
        numbers = self.cavity.numbers
        inside = {name: value for name, value in values.items() if name in numbers}
        changed: dict[str, Any] = {name: value for name, value in values.items() if name not in numbers}
        return replace(self, **changed, cavity=cavity_of(numbers | inside))


Built = Annotated[
    dict[str, float | str | None], Says(description="A damper, with its values in units and as ratios.")
]


def design_document(build: Build, asked: Specification) -> Built:
    """Return a damper as a document, with values in units and with ratios at the largest base amplitude.

    For a specification in ratios, values in units are None. If there are only records, ratios to a base
    amplitude are None.
    """
    amplitude = asked.largest_m if asked.excitations else 1.0
    _, restitution, mass, clearance, friction = build.place(asked.structure, amplitude)
    found: Built = {
        name: getattr(build, name) if asked.in_units or name == "restitution" else None for name in CHOSEN
    }
    ratios = dict(zip(RATIO_OF.values(), (clearance, friction, mass, restitution), strict=True))
    found |= {name: value for name, value in ratios.items() if name != "restitution"}
    found |= {name: value for name, value in build.cavity.numbers.items() if asked.choices[name].stop}
    if mass == 0.0:
        found |= dict.fromkeys(("clearance_m", "clearance_ratio", "restitution"))
        found |= dict.fromkeys(found.keys() & build.cavity.numbers)
    if asked.in_units:
        found["contact_time_s"] = build.contact_time_s if mass and build.contact_time_s else None
        found["cavity_length_m"] = None if mass == 0.0 else 2.0 * build.clearance_m
        found["base_amplitude_m"] = amplitude if asked.excitations else None
    if not asked.excitations:
        found |= dict.fromkeys(("clearance_ratio", "friction_ratio"))
    return found
