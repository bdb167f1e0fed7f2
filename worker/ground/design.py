"""A structure and its damper in physical units, and the length scale for computing a record."""

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
    """The primary structure; the paper's by default (its Table 2).

    Parameters
    ----------
    mass_kg, natural_frequency_hz, damping_ratio : float
        M, ω_n/2π and ζ.
    """

    mass_kg: float = 1.605
    natural_frequency_hz: float = 2.5
    damping_ratio: float = 0.0038

    @property
    def omega(self) -> float:
        """ω_n [rad/s]."""
        return 2.0 * pi * self.natural_frequency_hz

    @property
    def stiffness_n_per_m(self) -> float:
        """k [N/m]."""
        return self.mass_kg * self.omega**2


@dataclass(frozen=True)
class Damper:
    """A friction damper, a particle, or both.

    Parameters
    ----------
    friction_force_n : float
        F_f [N]; 0 for none.
    particle_mass_kg : float
        m [kg]; 0 for no particle.
    clearance_m : float
        d [m], free path of the particle to either side.
    restitution : float
        e.
    contact : Contact
        Model of an impact; a contact time is in units of 1/ω_n of the structure.
    cavity : Cavity
        Tilt of the particle's cavity, and friction in it; with instantaneous contact.
    """

    friction_force_n: float = 0.0
    particle_mass_kg: float = 0.0
    clearance_m: float = 0.0225
    restitution: float = 0.47
    contact: Contact = INSTANT
    cavity: Cavity = LEVEL


@dataclass(frozen=True)
class Scale:
    """Factors from the dimensionless numbers of a run to physical ones.

    The length is the largest base acceleration over ω_n²: the static displacement of the structure under it. So the
    largest value of the record is 1 in any units, and scaling a record together with d and F_f gives the same run.

    Parameters
    ----------
    length_m : float
        L = max |z''|/ω_n².
    omega : float
        ω_n [rad/s].
    mass_kg : float
        M.
    """

    length_m: float
    omega: float
    mass_kg: float

    @property
    def speed_m_s(self) -> float:
        """L ω_n."""
        return self.length_m * self.omega

    @property
    def acceleration_m_s2(self) -> float:
        """L ω_n², the largest base acceleration."""
        return self.length_m * self.omega**2

    @property
    def energy_j(self) -> float:
        """M (L ω_n)²."""
        return self.mass_kg * self.speed_m_s**2


def scale_of(structure: Structure, motion: GroundMotion, factor: float) -> Scale:
    """Scale of a record with a factor."""
    length = abs(factor) * motion.peak_m_s2 / structure.omega**2
    return Scale(length, structure.omega, structure.mass_kg)


def friction_of(damper: Damper, scale: Scale) -> float | None:
    """F_f/(k L), friction over the largest inertial force; None without friction."""
    if damper.friction_force_n <= 0.0:
        return None
    return damper.friction_force_n / (scale.mass_kg * scale.acceleration_m_s2)


def particle_of(damper: Damper, scale: Scale) -> Particle | None:
    """The particle in dimensionless numbers; None if no particle acts on the structure."""
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
