"""The particle of a scene and the walls that it strikes."""

from typing import NamedTuple

RUBBING = "rubbing"
"""What a scene calls the contact of a particle that rubs on its cavity: instantaneous impacts."""
FALLING = "falling"
"""The same of one that falls in its cavity."""


class Wall(NamedTuple):
    """A compliant wall: a spring and a dashpot side by side that push, and never pull (`physics.compliant_wall`).

    Attributes
    ----------
    stiffness, damping : float
        K over k, C over k/ω_n.
    """

    stiffness: float
    damping: float


class Particle(NamedTuple):
    """The particle of a scene; a scene without one passes None, and its kernel holds no impact code.

    Attributes
    ----------
    clearance_ratio, restitution, mass_ratio : float
        d/Z, e, β.
    contact_time : float or None
        How long the particle moves with a wall that it strikes [1/ω_n]; None where it leaves at once.
    wall : Wall or None
        Of a cavity with compliant walls, whose constants stand for e; None where walls are rigid.
    friction : float or None
        κ > 0 of a particle that rubs on its cavity, with instantaneous impacts; None where it slides freely. 0 where it only
        falls.
    gravity : float or None
        G > 0 along the cavity, towards negative u; None where that lies.
    """

    clearance_ratio: float
    restitution: float
    mass_ratio: float
    contact_time: float | None = None
    wall: Wall | None = None
    friction: float | None = None
    gravity: float | None = None


def with_floats(particle: Particle) -> Particle:
    """Particle with floats where integers may have been written: a kernel is compiled for one type."""
    contact_time = None if particle.contact_time is None else float(particle.contact_time)
    wall = (
        None if particle.wall is None else Wall(float(particle.wall.stiffness), float(particle.wall.damping))
    )
    return Particle(
        float(particle.clearance_ratio),
        float(particle.restitution),
        float(particle.mass_ratio),
        contact_time,
        wall,
        None if particle.friction is None else float(particle.friction),
        None if particle.gravity is None else float(particle.gravity),
    )
