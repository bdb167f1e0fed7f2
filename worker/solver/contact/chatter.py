"""Completion of a chatter, which is a sequence of ever faster impacts that ends in sustained contact."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.excitation import largest_forcing, with_force_bound
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene

# The last impacts of a chatter are omitted: the bodies join at the velocity that conserves their momentum.
# The error is of the order of (remaining time)³. Remaining times are fractions of a panel.
#
# A chatter is completed at the remaining time `_CHATTER_LEFT` if the acceleration of the wall is steady.
# The mass must not come to rest within the remaining time.
_CHATTER_LEFT = 5e-6
# Largest relative change of the wall's acceleration within `_CHATTER_LEFT` that is considered steady.
_STEADY_PUSH = 1e-3
# Remaining time at which every chatter is completed, because no other event happens in such a short time.
_NOTHING_LEFT = 1e-8
_LEAST_LOSS = 1e-3  # lower limit of the relative loss of speed in an impact


@inlined
def is_chatter_over(
    w: float, leaving: float, u_acceleration: float, closing: float, scene: Scene, particle: Particle
) -> bool:
    """Whether the remaining impacts of a chatter can be omitted.

    Parameters
    ----------
    w : float
        Velocity of the mass relative to the base after the last impact.
    leaving : float
        Speed at which the particle leaves the wall.
    u_acceleration, closing : float
        Acceleration of the mass, and acceleration with which the wall approaches the particle.
    """
    base = scene.base
    # Each flight is shorter than the previous flight by the factor e.
    # At e = 1 only friction shortens the flights, so a lower limit replaces 1 − e.
    impulse_left = 2.0 * leaving / max(1.0 - particle.restitution, _LEAST_LOSS)
    is_over: bool = impulse_left <= _NOTHING_LEFT * base.window * closing
    if particle.contact_time is None:
        return is_over or _is_steady_end(w, leaving, impulse_left, u_acceleration, closing, scene)
    # With a finite contact time, each impact holds the particle again.
    # A chatter therefore continues until its speed is within rounding.
    is_brief: bool = particle.contact_time <= _NOTHING_LEFT * base.window
    return is_over and is_brief


@inlined
def _is_steady_end(
    w: float, leaving: float, impulse_left: float, u_acceleration: float, closing: float, scene: Scene
) -> bool:
    """Whether a chatter ends soon under a steady acceleration of the wall, with no other event before its end."""
    base = scene.base
    chatter_left = _CHATTER_LEFT * base.window
    if impulse_left > chatter_left * closing:
        return False
    largest = largest_forcing(base)
    change = chatter_left * (
        with_force_bound(abs(w), base, 1) + base.two_zeta * (abs(u_acceleration) + largest)
    )
    if change > _STEADY_PUSH * closing:
        return False
    if scene.friction is not None:
        slips_on: bool = abs(w) >= 2.0 * (leaving + (abs(u_acceleration) + largest) * chatter_left)
        return slips_on
    return True
