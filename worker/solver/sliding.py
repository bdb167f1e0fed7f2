"""A particle with friction, or under gravity, in its cavity.

With neither friction nor gravity, every function in this module is a constant, which the compiler drops.

The particle slides with p'' = κ sgn(u' − p'), and pulls the mass by βκ sgn(u' − p') the other way. While |u''| ≤ κ,
friction may carry it along as one body with the mass. A pushing wall carries it along at any u''. Gravity adds −G to
p'', and u'' + G replaces u''. With gravity, u is measured from the rest position of the mass with the particle on its
lower wall. So βG acts on the mass while it does not carry the particle.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Slide, State


@inlined
def slide_at_rest(particle: Particle | None) -> Slide | None:
    """Slide of a carried particle; None with neither friction nor gravity."""
    if particle is None:
        return None
    if particle.friction is None:
        return None
    if particle.gravity is None:
        return Slide(0.0, 0, None)
    return Slide(0.0, 0, -1.0)


@inlined
def moving_slide(direction: float, particle: Particle) -> Slide:
    """Slide of a particle that moves in its cavity."""
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
    """Sign of u' − p' of a particle with friction; 0 if it is carried or has no friction."""
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
    """Number of leading Taylor coefficients of u' − p' that are zero; 0 without friction of the particle."""
    if slide is None:
        return 0
    return slide.order


@inlined
def fall_of(slide: Slide | None, particle: Particle) -> float:
    """Acceleration of a free particle by gravity; 0 without gravity."""
    if particle.gravity is not None and slide is not None and slide.down is not None:
        return particle.gravity * slide.down
    return 0.0


@inlined
def with_pull(force: float, state: State, particle: Particle | None) -> float:
    """Add the force of the particle to a force on the mass against u, over k Z.

    If the particle is not carried, the mass gives it its acceleration p'', but does not bear its weight. With neither
    friction nor gravity the force is unchanged.
    """
    if particle is not None:
        if particle.friction is not None and state.riding == 0.0:
            return force + particle.mass_ratio * acceleration_of(state, particle)
    return force


@inlined
def acceleration_of(state: State, particle: Particle) -> float:
    """p'' between impacts, of a particle that is not carried."""
    if particle.friction is not None and state.slide is not None:
        return with_fall(particle.friction * state.slide.direction, state.slide, particle)
    return 0.0


@inlined
def with_fall(acceleration: float, slide: Slide | None, particle: Particle) -> float:
    """Add the acceleration by gravity to that of a particle; unchanged without gravity."""
    if particle.gravity is not None:
        return acceleration + fall_of(slide, particle)
    return acceleration


@inlined
def without_fall(acceleration: float, slide: Slide | None, particle: Particle) -> float:
    """Subtract the acceleration by gravity, to give the part that friction or a wall must supply; unchanged without
    gravity.
    """
    if particle.gravity is not None:
        return acceleration - fall_of(slide, particle)
    return acceleration


@inlined
def largest_of(particle: Particle) -> float:
    """Largest |p''| of a particle that is not carried."""
    if particle.friction is None:
        return 0.0
    if particle.gravity is None:
        return particle.friction
    return particle.friction + particle.gravity
