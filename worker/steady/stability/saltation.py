"""Effect of an event on tangent vectors: one saltation law for all contact models.

All events have the same form (Aizerman & Gantmakher 1958; Leine & Nijmeijer 2004, ch. 7). An event occurs where a
coordinate i reaches a given value, so the time of the event changes by δt = −δz_i / f_i. The event changes w by −q g,
the last coordinate from g to k g, and the vector field from f⁻ to f⁺:

    δz⁺ = R (δz⁻ + f⁻ δt) − f⁺ δt,    R: w → w − q g, g → k g.

A reversal or a strike on a compliant wall has q = 0, k = 1. An impact has q = β(1+e)/(1+β), k = −e or, if it
completes a chatter, q = β/(1+β), k = 0. The beginning of a dwell has q = β/(1+β), k = 1, because the approach
speed remains a coordinate; the end of a dwell has q = βe/(1+β), k = −e. A particle with friction comes to
rest in its cavity where y' is 0, with q = 0, k = 1. An event at which the vector field does not jump has no
effect on tangent vectors: the onset of slip, a contact force that falls to zero, and a particle that clears a
wall.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.events import NEAR_WALL
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import motion_of, slip_regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.transition_log import Side, Transition, transition_at

Array = NDArray[np.float64]

# Longest duration [1/ω_n] for which the mean acceleration of a flight is computed from its two ends.
# The relative error is 1e-11.
_SHORT_FLIGHT = 1e-5


class Field(NamedTuple):
    """The vector field on one side of an event: the rates of v, w, y and y'.

    In a contact with its own coordinates, the rates of these coordinates replace those of y and y'.
    """

    v: float
    w: float
    y: float
    y_rate: float


@inlined
def field(side: Side, event: Transition, scene: Scene) -> Field:
    """Compute the vector field on one side of an event."""
    base, particle = scene.base, scene.particle
    w = side.w
    inertia_force = event.inertia_force
    riding = side.riding > 0.0
    held, offset = slip_regime(side.slip, scene.friction)
    wall_force = 0.0  # force of a compliant wall on the particle
    p_acceleration = 0.0
    if particle is not None:
        if particle.wall is not None:
            if riding:
                wall_force = side.wall * (
                    particle.wall.damping * side.speed - particle.wall.stiffness * side.gap
                )
        if particle.friction is not None:
            p_acceleration = particle.friction * side.slide
            if particle.gravity is not None:
                p_acceleration += particle.gravity * side.down
            if not riding:
                offset += particle.mass_ratio * p_acceleration
    a = 0.0
    if not held:
        taken = base.two_zeta * w + event.v + offset - event.force
        a = inertia_force - motion_of(side.riding, scene).compliance * taken - wall_force
    if particle is not None:
        if not riding:
            u_rate = w + event.base_rate
            bent = a - inertia_force
            if particle.friction is not None:
                bent -= p_acceleration
            return Field(w, a, u_rate - side.p_rate, bent)
        if particle.wall is not None:
            rate = side.wall * side.speed
            return Field(w, a, rate, a - inertia_force - wall_force / particle.mass_ratio)
        if side.speed > 0.0:  # the remaining time of a dwell decreases
            return Field(w, a, -side.wall, 0.0)
    return Field(w, a, 0.0, 0.0)


@inlined
def leaving_speed(
    rows: Array, event: Transition, to: int, count: int, scene: Scene, particle: Particle
) -> float:
    """Speed at which a particle leaves the wall at the end of its dwell.

    The leaving speed is e times the approach speed. In a chatter, the leaving speed becomes smaller than the
    rounding error of the velocities. The logged duration of the flight is then inconsistent with the leaving
    speed, and the use of both would make the propagation through the next impact inaccurate. For a short
    flight that ends on the same wall, the leaving speed is therefore computed from the duration and the final
    impact of the flight.
    """
    known: float = particle.restitution * event.before.speed
    gained = 0.0
    length = 0.0
    here = transition_at(rows, to)
    for i in range(to + 1, count):
        following = transition_at(rows, i)
        start = field(here.after, here, scene)
        end = field(following.before, following, scene)
        length += following.span
        gained += 0.5 * following.span * (start.y_rate + end.y_rate)
        if length > _SHORT_FLIGHT or following.before.riding > 0.0:
            return known
        if following.event == NEAR_WALL and following.after.speed > 0.0:
            speed: float = event.before.wall * gained - following.after.speed
            return speed
        here = following
    return known


@inlined
def pass_contact(
    ends: Side,
    let_go: bool,
    before: Field,
    after: Field,
    particle: Particle,
    z: Array,
    n: int,
) -> None:
    """Propagate tangent vectors through an event at which the particle meets a wall or detaches from a wall.

    `ends` is the state just after the event.
    """
    if particle.wall is not None:  # at a compliant wall, only the vector field jumps, not the velocities
        pass_event(2, before.y, 0.0, 1.0, before, after, z, n)
        return
    share = particle.mass_ratio / (1.0 + particle.mass_ratio)
    flies = ends.riding == 0.0
    if let_go:
        kept = -particle.restitution if flies else 0.0
        if not flies:
            after = after._replace(y=0.0, y_rate=0.0)
        pass_event(2, before.y, -share * kept, kept, before, after, z, n)
    elif flies:
        kept = -particle.restitution
        after = after._replace(y=kept * before.y)
        pass_event(2, before.y, share * (1.0 - kept), kept, before, after, z, n)
    else:  # a dwell, or the completion of a chatter
        pass_event(2, before.y, share, 1.0 if ends.speed > 0.0 else 0.0, before, after, z, n)


@inlined
def pass_event(
    reaches: int, rate: float, exchanged: float, kept: float, before: Field, after: Field, z: Array, n: int
) -> None:
    """Apply the saltation law δz⁺ = R (δz⁻ + f⁻ δt) − f⁺ δt to tangent vectors.

    Parameters
    ----------
    reaches : int
        Index of the coordinate that reaches a given value at the event: 1, 2 or 3.
    rate : float
        Rate of this coordinate before the event. If this rate is zero, the event is a touch, which has no
        linearisation, and nothing is changed.
    exchanged, kept : float
        q and k of the reset map.
    before, after : Field
        f⁻ and f⁺.
    """
    if rate == 0.0:
        return
    for j in range(n):
        dt = -z[reaches * n + j] / rate
        y = 0.0 if reaches == 2 else z[2 * n + j] + before.y * dt
        y_rate = 0.0 if reaches == 3 else z[3 * n + j] + before.y_rate * dt
        z[j] += (before.v - after.v) * dt
        z[n + j] += (before.w - after.w) * dt - exchanged * y_rate
        z[2 * n + j] = y - after.y * dt
        z[3 * n + j] = kept * y_rate - after.y_rate * dt
