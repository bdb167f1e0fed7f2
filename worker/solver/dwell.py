"""The dwell, during which the particle stays on a wall for the contact time."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.state import Dwell


@inlined
def dwell_at_rest(particle: Particle | None) -> Dwell | None:
    """A `Dwell` without a contact, for a particle in flight; None if impacts are instantaneous."""
    if particle is None:
        return None
    if particle.contact_time is None and particle.wall is None:
        return None
    return Dwell(0.0, 0.0)


@inlined
def no_dwell(dwell: Dwell | None) -> Dwell | None:
    """Return a dwell of length 0; None if impacts are instantaneous."""
    if dwell is None:
        return None
    return Dwell(0.0, 0.0)


@inlined
def dwell_on(dwell: Dwell | None, time: float) -> Dwell | None:
    """Return the dwell that remains after a given time."""
    if dwell is None:
        return None
    return Dwell(max(dwell.left - time, 0.0), dwell.speed)


@inlined
def is_dwelling(dwell: Dwell | None) -> bool:
    """Whether the particle dwells on its wall."""
    if dwell is None:
        return False
    return dwell.left > 0.0


@inlined
def time_left(dwell: Dwell | None) -> float:
    """Time until detachment [1/ω_n]."""
    if dwell is None:
        return 0.0
    return dwell.left


@inlined
def approach_speed(dwell: Dwell | None) -> float:
    """Approach speed of a dwelling particle; on a compliant wall, the present rate of penetration [Z ω_n]."""
    if dwell is None:
        return 0.0
    return dwell.speed
