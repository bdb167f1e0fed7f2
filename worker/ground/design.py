"""A structure and its damper in physical units, and factors that convert dimensionless results to physical units."""

from dataclasses import dataclass
from math import pi

from damperlab.studies.cavity import LEVEL, Cavity
from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.variables import BEFORE
from damperlab.worker.kernel_arguments import acting, contact_time_of, rebound_of, wall_of
from damperlab.worker.solver.particle import Particle

INSTANT = InstantContact()


@dataclass(frozen=True)
class Structure:
    """Primary structure. The defaults are from the paper's Table 2.

    Parameters
    ----------
    mass_kg, natural_frequency_hz, damping_ratio : float
        Mass M [kg], natural frequency ω_n/2π [Hz] and damping ratio ζ.
    """

    mass_kg: float = 1.605
    natural_frequency_hz: float = 2.5
    damping_ratio: float = 0.0038

    @property
    def omega(self) -> float:
        """Natural angular frequency ω_n [rad/s]."""
        return 2.0 * pi * self.natural_frequency_hz

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness k [N/m]."""
        return self.mass_kg * self.omega**2


@dataclass(frozen=True)
class Damper:
    """A friction damper, a particle damper, or both.

    Parameters
    ----------
    friction_force_n : float
        Friction force F_f [N]; 0 without friction.
    particle_mass_kg : float
        Mass m of the particle [kg]; 0 without a particle.
    clearance_m : float
        Clearance d [m], the free path of the particle from the middle to either wall.
    restitution : float
        Coefficient of restitution e.
    contact : Contact
        Contact model for impacts. A contact time is in units of 1/ω_n of the structure.
    cavity : Cavity
        Tilt of the cavity and friction of the particle in it, both of which require instantaneous impacts.
    """

    friction_force_n: float = 0.0
    particle_mass_kg: float = 0.0
    clearance_m: float = 0.0225
    restitution: float = 0.47
    contact: Contact = INSTANT
    cavity: Cavity = LEVEL


@dataclass(frozen=True)
class Scale:
    """Factors that convert dimensionless results to physical units.

    The length is the largest base acceleration over ω_n², so the largest dimensionless acceleration of the base is 1.
    If a record is scaled together with d and F_f, the dimensionless motion does not change.

    Parameters
    ----------
    length_m : float
        Length L = max |z''|/ω_n² [m].
    omega : float
        Natural angular frequency ω_n [rad/s].
    mass_kg : float
        Mass M of the structure [kg].
    """

    length_m: float
    omega: float
    mass_kg: float

    @property
    def speed_m_s(self) -> float:
        """Factor L ω_n for speeds [m/s]."""
        return self.length_m * self.omega

    @property
    def acceleration_m_s2(self) -> float:
        """Factor L ω_n² for accelerations [m/s²], equal to the largest base acceleration."""
        return self.length_m * self.omega**2

    @property
    def energy_j(self) -> float:
        """Factor M (L ω_n)² for energies [J]."""
        return self.mass_kg * self.speed_m_s**2


def scale_of(structure: Structure, motion: GroundMotion, factor: float) -> Scale:
    """Return the units of length, frequency and mass for a structure under a record multiplied by `factor`."""
    length = abs(factor) * motion.peak_m_s2 / structure.omega**2
    return Scale(length, structure.omega, structure.mass_kg)


def friction_of(damper: Damper, scale: Scale) -> float | None:
    """Return F_f/(k L), the ratio of the friction force to the largest inertial force, or None without friction."""
    if damper.friction_force_n <= 0.0:
        return None
    return damper.friction_force_n / (scale.mass_kg * scale.acceleration_m_s2)


def particle_of(damper: Damper, scale: Scale) -> Particle | None:
    """Return the particle in dimensionless numbers, or None without a particle."""
    if damper.particle_mass_kg <= 0.0:
        return None
    restitution, mass_ratio = float(damper.restitution), damper.particle_mass_kg / scale.mass_kg
    cavity = damper.cavity
    case = {
        "mass_kg": scale.mass_kg,
        "natural_frequency_hz": scale.omega / (2.0 * pi),
        "base_amplitude_m": scale.length_m,
        "particle_mass_kg": damper.particle_mass_kg,
    }
    ratios = cavity.ratios(case) if cavity.acts else (0.0,) * len(BEFORE)
    return Particle(
        damper.clearance_m / scale.length_m,
        rebound_of(restitution),
        mass_ratio,
        contact_time_of(damper.contact),
        wall_of(damper.contact, restitution, mass_ratio),
        *acting(dict(zip(BEFORE, ratios, strict=True))),
    )
