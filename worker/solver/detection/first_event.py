"""The first event of a segment: rest, onset of slip, contact with a wall, detachment, or end of a dwell."""

from math import inf

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.detection.bounds import u_derivative_bound, w_curvature_bound, w_rate_bound
from damperlab.worker.solver.dwell import is_dwelling, time_left
from damperlab.worker.solver.events import (
    FAR_WALL,
    LET_GO,
    NEAR_WALL,
    NOTHING,
    RELEASE,
    REST,
    SLIP_ONSET,
    TURN,
)
from damperlab.worker.solver.excitation.excitation import (
    expand_forcing,
    forcing_derivative_bound,
    largest_forcing,
    largest_to_hold,
)
from damperlab.worker.solver.motion.first_root import first_beyond, first_crossing
from damperlab.worker.solver.motion.taylor import TERMS, acceleration_into, rate_into
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene
from damperlab.worker.solver.sliding import (
    acceleration_of,
    direction_of,
    fall_of,
    largest_of,
    order_of,
    with_pull,
)
from damperlab.worker.solver.state import State

# 2/(k + 2)! for k = 0 to 3, where k roots at t = 0 are divided out of a function p.
# This factor converts a bound on the derivative of p of order k + 2 into a bound on the curvature of p(t)/t^k.
_CURVATURE_WITHOUT_ROOTS = (1.0, 1.0 / 3.0, 1.0 / 12.0, 1.0 / 60.0)


@inlined
def next_event(segment: Segment, scene: Scene, curves: Curves) -> tuple[float, int]:
    """Return time and kind of the first event in a segment, or the length of the segment and NOTHING."""
    t, kind = segment.time, NOTHING
    if scene.friction is not None:
        t, kind = _friction_event(segment, scene, scene.friction, curves)
    if scene.particle is not None:
        start, particle = segment.start, scene.particle
        if is_dwelling(start.dwell):
            if time_left(start.dwell) <= t:
                t, kind = time_left(start.dwell), LET_GO
        elif start.riding == 0.0:
            t, kind = _wall_event(segment, scene, particle, curves, t, kind)
            if particle.friction is not None:
                t, kind = _rest_event(segment, scene, particle, curves, t, kind)
        elif particle.friction is not None:
            t, kind = _torn_loose(segment, scene, particle, particle.friction, curves, t, kind)
        else:  # the wall may stop pushing the particle
            acceleration_into(curves.absolute, curves.scratch)
            curvature = u_derivative_bound(4, segment, scene.base)
            found = first_crossing(curves.scratch, start.wall, 0.0, t, curvature)
            if found < inf:
                t, kind = found, RELEASE
    return t, kind


@inlined
def _friction_event(segment: Segment, scene: Scene, friction: float, curves: Curves) -> tuple[float, int]:
    """Find the time at which a sticking mass starts to slip, or a slipping mass comes to rest."""
    base, start, scratch = scene.base, segment.start, curves.scratch
    t, kind = segment.time, NOTHING
    if segment.regime.sticks:
        inertia = 1.0 / segment.regime.motion.compliance
        expand_forcing(base, segment.phase, -1.0, inertia, scratch)
        curvature = forcing_derivative_bound(base, segment.phase, 2, inertia)
        limit = breakaway(friction, largest_to_hold(base, inertia))
        v = with_pull(start.v, start, scene.particle)
        found = first_beyond(scratch, v, limit, t, curvature)
        if found < inf:
            t, kind = found, SLIP_ONSET
    elif start.slip_order > 0 or abs(start.w) <= segment.time * w_rate_bound(segment, base):
        order = start.slip_order
        rate_into(curves.relative, order, scratch)
        found = first_crossing(scratch, start.slip, 0.0, t, w_curvature_bound(order, segment, base))
        if found < inf:
            t, kind = found, TURN
    return t, kind


@inlined
def _wall_event(
    segment: Segment, scene: Scene, particle: Particle, curves: Curves, t: float, kind: int
) -> tuple[float, int]:
    """Find the time at which a particle in flight meets a wall.

    Return time and kind of this contact or of the event (t, kind), whichever is earlier.
    """
    start, scratch = segment.start, curves.scratch
    order = start.gap_order
    rate = start.wall * (start.p_rate - curves.absolute[1])
    bent = segment.bounds.u2 + largest_of(particle)
    sag = 0.5 * bent * t * t
    if order > 0 or start.gap + min(0.0, rate * t) - sag <= 0.0:
        _expand_gap(start.gap, rate, order, start, particle, curves.absolute, scratch)
        curvature = u_derivative_bound(2 + order, segment, scene.base)
        if order == 0:
            curvature += largest_of(particle)
        curvature *= _CURVATURE_WITHOUT_ROOTS[order]
        found = first_crossing(scratch, 1.0, 0.0, t, curvature)
        if found < inf:
            t, kind = found, NEAR_WALL
    widest = 2.0 * particle.clearance_ratio
    if start.gap + max(0.0, rate * t) + sag >= widest:
        _expand_gap(start.gap - widest, rate, 0, start, particle, curves.absolute, scratch)
        found = first_crossing(scratch, -1.0, 0.0, t, bent)
        if found < inf:
            t, kind = found, FAR_WALL
    return t, kind


@inlined
def _expand_gap(
    gap: float, rate: float, order: int, start: State, particle: Particle, absolute: Floats, out: Floats
) -> None:
    """Write the coefficients of gap/t^order.

    If the particle has just left the wall, the `order` lowest coefficients of the gap are zero.
    """
    for i in range(max(2 - order, 0), TERMS - order):
        out[i] = -start.wall * absolute[i + order]
    for i in range(TERMS - order, TERMS):
        out[i] = 0.0
    if order < 2:
        out[1 - order] = rate
    if order < 1:
        out[0] = gap
    if particle.friction is not None:
        if order <= 2:
            out[2 - order] += start.wall * 0.5 * acceleration_of(start, particle)


@inlined
def _torn_loose(
    segment: Segment, scene: Scene, particle: Particle, friction: float, curves: Curves, t: float, kind: int
) -> tuple[float, int]:
    """Find the time at which friction and the push of a touched wall can no longer carry the particle."""
    start, scratch = segment.start, curves.scratch
    limit = breakaway(friction, largest_forcing(scene.base))
    curvature = u_derivative_bound(4, segment, scene.base)
    acceleration_into(curves.absolute, scratch)
    scratch[0] = (scratch[0] - fall_of(start.slide, particle)) + start.wall * limit
    found = first_crossing(scratch, start.wall, 0.0, t, curvature)
    if found < inf:
        t, kind = found, RELEASE
    if start.gap > 0.0:
        scratch[0] -= 2.0 * start.wall * limit
        found = first_crossing(scratch, -start.wall, 0.0, t, curvature)
        if found < inf:
            t, kind = found, RELEASE
    return t, kind


@inlined
def _rest_event(
    segment: Segment, scene: Scene, particle: Particle, curves: Curves, t: float, kind: int
) -> tuple[float, int]:
    """Find the time at which a sliding particle reaches the velocity of the mass."""
    start, scratch = segment.start, curves.scratch
    order = order_of(start.slide)
    gained = acceleration_of(start, particle)
    speed = direction_of(start.slide) * (curves.absolute[1] - start.p_rate)
    if order > 0 or speed <= t * (segment.bounds.u2 + largest_of(particle)):
        rate_into(curves.absolute, order, scratch)
        if order == 0:
            scratch[0] -= start.p_rate
        if order < 2:
            scratch[1 - order] -= gained
        curvature = u_derivative_bound(3 + order, segment, scene.base) * _CURVATURE_WITHOUT_ROOTS[order]
        found = first_crossing(scratch, direction_of(start.slide), 0.0, t, curvature)
        if found < inf:
            t, kind = found, REST
    return t, kind
