"""The particle held on a wall for a contact time. Without one every function here is a constant that the compiler drops."""

from numba import types

from damperlab.worker.jit import by_type, inlined
from damperlab.worker.solver.state import Dwell, Particle


def dwell_at_rest(particle: Particle | None) -> Dwell | None:
    """What a particle that has met no wall yet remembers: None where contacts take no time."""
    at_once = particle is None or (particle.contact_time is None and particle.wall is None)
    return None if at_once else Dwell(0.0, 0.0)


@by_type(dwell_at_rest)
def _dwell_at_rest(particle):  # numba wants the same bare arguments in both forms
    """By type, because a kernel with branches of both kinds would make every state carry a flag."""
    takes_time = isinstance(particle, types.BaseNamedTuple) and not all(
        isinstance(particle.types[particle.fields.index(name)], types.NoneType)
        for name in ("contact_time", "wall")
    )
    if takes_time:
        return lambda particle: Dwell(0.0, 0.0)
    return lambda particle: None


@inlined
def no_dwell(dwell):
    """The particle is not held."""
    if dwell is not None:
        dwell = Dwell(0.0, 0.0)
    return dwell


@inlined
def dwell_on(dwell, time):
    """The same a time later."""
    if dwell is not None:
        dwell = Dwell(max(dwell.left - time, 0.0), dwell.speed)
    return dwell


@inlined
def is_dwelling(dwell):
    """Whether the particle is held on its wall."""
    if dwell is not None:
        return dwell.left > 0.0
    return False


@inlined
def time_left(dwell):
    """Time until the particle is let go [1/ω_n]."""
    if dwell is not None:
        return dwell.left
    return 0.0


@inlined
def approach_speed(dwell):
    """Speed at which the particle met the wall that holds it [Z ω_n]."""
    if dwell is not None:
        return dwell.speed
    return 0.0


@inlined
def is_brief(contact_time, limit):
    """Whether contacts take no time, or less than the limit."""
    if contact_time is not None:
        return contact_time <= limit
    return True
