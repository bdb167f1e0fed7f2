"""A particle that rubs on its cavity. Where it does not, every function here is a constant that the compiler drops.

The particle slides with p'' = κ sgn(u' − p'), and pulls the mass by βκ sgn(u' − p') the other way. Or friction carries it
along, as one body with the mass, while |u''| ≤ κ. A wall that pushes carries it whatever u'' is.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Slide, State


@inlined
def slide_at_rest(particle: Particle | None) -> Slide | None:
    """A particle that is carried along; None where none rubs."""
    if particle is None:
        return None
    if particle.friction is None:
        return None
    return Slide(0.0, 0)


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
def order_of(slide: Slide | None) -> int:
    """How many leading Taylor coefficients of u' − p' are zero; 0 where no particle rubs."""
    if slide is None:
        return 0
    return slide.order


@inlined
def with_pull(force: float, state: State, particle: Particle | None) -> float:
    """A force on the mass against u, over k Z, with that of the particle that rubs; the same where none does."""
    if particle is not None:
        if particle.friction is not None and state.slide is not None:
            return force + particle.mass_ratio * particle.friction * state.slide.direction
    return force


@inlined
def acceleration_of(state: State, particle: Particle) -> float:
    """p'' between impacts, of a particle that is not carried."""
    if particle.friction is not None and state.slide is not None:
        return particle.friction * state.slide.direction
    return 0.0


@inlined
def largest_of(particle: Particle) -> float:
    """Largest |p''| of a particle that is not carried."""
    if particle.friction is not None:
        return particle.friction
    return 0.0
