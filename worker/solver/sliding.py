"""A particle with friction, or under gravity, in its cavity.

A sliding particle has p'' = κ sgn(u' − p') and pulls the mass in the opposite direction with the force
βκ sgn(u' − p'). While |u''| ≤ κ, friction can carry the particle along with the mass. A pushing wall carries
the particle along at any u''. Gravity adds −G to p''; friction can then carry the particle while
|u'' + G| ≤ κ. With gravity, u is measured from the rest position of the mass with the particle on its lower
wall. While the particle slides, its weight does not act on the mass; this corresponds to a force βG on the
mass against gravity.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Slide, State


@inlined
def slide_at_rest(particle: Particle | None) -> Slide | None:
    """Return the `Slide` of a particle that the mass carries; None without friction and gravity."""
    if particle is None:
        return None
    if particle.friction is None:
        return None
    return moving_slide(0.0, particle)


@inlined
def moving_slide(direction: float, particle: Particle) -> Slide:
    """Return the `Slide` of a particle that moves in its cavity."""
    if particle.gravity is None:
        return Slide(direction, 0, None)
    return Slide(direction, 0, -1.0)


@inlined
def rubs(particle: Particle | None) -> bool:
    """Whether a particle has friction in its cavity."""
    if particle is None:
        return False
    return particle.friction is not None


@inlined
def direction_of(slide: Slide | None) -> float:
    """Sign of u' − p' of a particle with friction; 0 if the mass carries the particle, or without friction."""
    if slide is None:
        return 0.0
    return slide.direction


@inlined
def down_of(slide: Slide | None) -> float:
    """Direction of gravity, as in `Slide`; 0 without gravity."""
    if slide is None or slide.down is None:
        return 0.0
    return slide.down


@inlined
def order_of(slide: Slide | None) -> int:
    """Number of leading Taylor coefficients of u' − p' that are zero; 0 for a particle without friction."""
    if slide is None:
        return 0
    return slide.order


@inlined
def fall_of(slide: Slide | None, particle: Particle) -> float:
    """Acceleration of gravity, with the sign of `Slide.down`; 0 without gravity."""
    if particle.gravity is not None and slide is not None and slide.down is not None:
        return particle.gravity * slide.down
    return 0.0


@inlined
def with_pull(force: float, state: State, particle: Particle | None) -> float:
    """Return a force on the mass plus the force of a sliding particle.

    Both forces are divided by k Z, and are positive towards −u.

    The force is βp'' while the particle slides, and 0 while the mass carries the particle. With gravity, βp'' includes
    −βG, because the mass does not bear the weight of a sliding particle.
    """
    if particle is not None:
        if particle.friction is not None and state.riding == 0.0:
            return force + particle.mass_ratio * acceleration_of(state, particle)
    return force


@inlined
def acceleration_of(state: State, particle: Particle) -> float:
    """Acceleration p'' of a sliding particle between impacts; 0 without friction and gravity."""
    if particle.friction is not None and state.slide is not None:
        rubbing = particle.friction * state.slide.direction
        return rubbing + fall_of(state.slide, particle)
    return 0.0


@inlined
def largest_of(particle: Particle) -> float:
    """Largest |p''| of a sliding particle; 0 without friction and gravity."""
    if particle.friction is None:
        return 0.0
    if particle.gravity is None:
        return particle.friction
    return particle.friction + particle.gravity
