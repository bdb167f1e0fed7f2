"""The particle of a scene and its walls."""

from typing import NamedTuple

RUBBING = "rubbing"
"""Contact model of a particle with friction in its cavity; impacts are instantaneous."""
FALLING = "falling"
"""Contact model of a particle under gravity in its cavity."""


class Wall(NamedTuple):
    """A compliant wall: a spring and a dashpot in parallel, which push but never pull (`physics.compliant_wall`).

    Attributes
    ----------
    stiffness, damping : float
        Stiffness K over k, and damping C over k/ω_n.
    """

    stiffness: float
    damping: float


class Particle(NamedTuple):
    """The particle of a scene.

    Attributes
    ----------
    clearance_ratio, restitution, mass_ratio : float
        d/Z, e, β.
    contact_time : float or None
        Time for which the particle stays on a wall after an impact [1/ω_n]; None if the particle leaves immediately.
    wall : Wall or None
        Stiffness and damping of compliant walls, which replace e; None for rigid walls.
    friction : float or None
        κ of a particle with friction in its cavity; 0 if only gravity acts, None without friction and gravity. With
        friction or gravity, impacts are instantaneous.
    gravity : float or None
        G > 0, which acts along the cavity towards negative u; None if the cavity is level.
    """

    clearance_ratio: float
    restitution: float
    mass_ratio: float
    contact_time: float | None = None
    wall: Wall | None = None
    friction: float | None = None
    gravity: float | None = None


def with_floats(particle: Particle) -> Particle:
    """Convert the numbers of a particle to floats, the only type for which kernels are compiled."""
    wall = None if particle.wall is None else Wall(*map(float, particle.wall))
    numbers = particle._replace(wall=None)
    return Particle(*(None if number is None else float(number) for number in numbers))._replace(wall=wall)  # type: ignore[arg-type]
