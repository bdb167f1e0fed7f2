"""A particle that rubs on its cavity, or falls in it. Where it does neither, every function here is a constant that is dropped.

The particle slides with p'' = κ sgn(u' − p'), and pulls the mass by βκ sgn(u' − p') the other way. Or friction carries it
along, as one body with the mass, while |u''| ≤ κ. A wall that pushes carries it whatever u'' is. Gravity adds −G to p'', and
u'' + G stands for u''. There u is measured from where the mass rests with the particle on its lower wall; so the mass feels βG
where it does not carry the particle.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Slide, State


@inlined
def slide_at_rest(particle: Particle | None) -> Slide | None:
    """A particle that is carried along; None where none rubs or falls."""
    if particle is None:
        return None
    if particle.friction is None:
        return None
    if particle.gravity is None:
        return Slide(0.0, 0, None)
    return Slide(0.0, 0, -1.0)


@inlined
def moving_slide(direction: float, particle: Particle) -> Slide:
    """A particle that slides."""
    if particle.gravity is None:
        return Slide(direction, 0, None)
    return Slide(direction, 0, -1.0)


@inlined
def rubs(particle: Particle | None) -> bool:
    """Whether a particle has friction of its own."""
    if particle is None:
        return False
    return particle.friction is not None


@inlined
def direction_of(slide: Slide | None) -> float:
    """Sign of u' − p' of a particle that rubs, 0 where it is carried, or does not rub."""
    if slide is None:
        return 0.0
    return slide.direction


@inlined
def down_of(slide: Slide | None) -> float:
    """Where gravity acts, as `Slide` has it; 0 where none does."""
    if slide is None or slide.down is None:
        return 0.0
    return slide.down


@inlined
def order_of(slide: Slide | None) -> int:
    """How many leading Taylor coefficients of u' − p' are zero; 0 where no particle rubs."""
    if slide is None:
        return 0
    return slide.order


@inlined
def fall_of(slide: Slide | None, particle: Particle) -> float:
    """Acceleration of a free particle by gravity; 0 where none acts."""
    if particle.gravity is not None and slide is not None and slide.down is not None:
        return particle.gravity * slide.down
    return 0.0


@inlined
def with_pull(force: float, state: State, particle: Particle | None) -> float:
    """A force on the mass against u, over k Z, with that of the particle; the same where none rubs.

    A particle that is not carried takes the acceleration p'', which the mass gives it; of the weight it bears nothing.
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
    """An acceleration of a particle with that by gravity; the same where none acts."""
    if particle.gravity is not None:
        return acceleration + fall_of(slide, particle)
    return acceleration


@inlined
def without_fall(acceleration: float, slide: Slide | None, particle: Particle) -> float:
    """An acceleration less that by gravity: what friction, or a wall, has to give; the same where none acts."""
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
