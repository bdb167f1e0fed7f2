"""Proofs that a segment has no event."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.detection.bounds import u_derivative_bound, w_curvature_bound, w_rate_bound
from damperlab.worker.solver.dwell import is_dwelling, time_left
from damperlab.worker.solver.excitation.excitation import (
    Excitation,
    Phase,
    force_to_hold,
    forcing_derivative_bound,
    net_resistance,
)
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import Regime, Segment
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import direction_of, largest_of, order_of, with_pull, without_fall
from damperlab.worker.solver.state import State


@inlined
def gap_rate(state: State, phase: Phase) -> float:
    """Rate of increase of the gap between the particle and the wall last touched."""
    return state.wall * (state.p_rate - (state.w + phase.rate))


@inlined
def wall_acceleration(state: State, phase: Phase, regime: Regime, base: Excitation) -> float:
    """u'', the acceleration that the wall transmits to a particle in sustained contact."""
    if regime.sticks:
        return -phase.inertia_force
    slips = net_resistance(base, phase, base.two_zeta * state.w + state.v + regime.offset)
    return -regime.motion.compliance * slips


@inlined
def is_free_between(segment: Segment, scene: Scene) -> bool:
    """Whether bounds prove that a complete panel has no event.

    Each event is a zero of a function of time. Inside the panel, this function is at least the smaller of its end
    values, minus time²/8 times a bound on its curvature.
    """
    base, start, end, regime = scene.base, segment.start, segment.end, segment.regime
    window: float = base.window
    share = 0.125 * window * window
    if start.slip_order + start.gap_order + order_of(start.slide) > 0:
        return False
    if scene.friction is not None:
        if regime.sticks:
            inertia = 1.0 / regime.motion.compliance
            v = with_pull(start.v, start, scene.particle)
            force_start = abs(force_to_hold(base, segment.phase, v, inertia))
            force_end = abs(force_to_hold(base, segment.phase_end, v, inertia))
            curvature = forcing_derivative_bound(base, segment.phase, 2, inertia)
            if max(force_start, force_end) + share * curvature >= scene.friction:
                return False
        else:
            sag = share * w_curvature_bound(0, segment, base)
            if min(start.slip * start.w, start.slip * end.w) <= sag:
                return False
    if scene.particle is not None:
        if scene.particle.friction is not None:
            return _rubs_on_between(segment, scene, scene.particle, scene.particle.friction, share)
        if is_dwelling(start.dwell):
            return time_left(start.dwell) > window
        if start.riding > 0.0:
            sag = share * u_derivative_bound(4, segment, base)
            contact_force = start.wall * wall_acceleration(start, segment.phase, regime, base)
            contact_force_end = start.wall * wall_acceleration(end, segment.phase_end, regime, base)
            at_rest = contact_force == 0.0 and contact_force_end == 0.0 and sag == 0.0
            if min(contact_force, contact_force_end) <= sag and not at_rest:
                return False
        else:
            sag = share * segment.bounds.u2
            if min(start.gap, end.gap) <= sag:
                return False
            if max(start.gap, end.gap) + sag >= 2.0 * scene.particle.clearance_ratio:
                return False
    return True


@inlined
def is_free_from(segment: Segment, scene: Scene) -> bool:
    """Whether bounds from the start of a segment prove that the segment has no event."""
    base, start, regime, time = scene.base, segment.start, segment.regime, segment.time
    if scene.friction is not None:
        if regime.sticks:
            inertia = 1.0 / regime.motion.compliance
            v = with_pull(start.v, start, scene.particle)
            force_start = abs(force_to_hold(base, segment.phase, v, inertia))
            if (
                force_start + forcing_derivative_bound(base, segment.phase, 1, inertia) * time
                >= scene.friction
            ):
                return False
        elif start.slip_order > 0 or abs(start.w) <= time * w_rate_bound(segment, base):
            return False
    if scene.particle is not None:
        if scene.particle.friction is not None:
            return _rubs_on_from(segment, scene, scene.particle, scene.particle.friction)
        if is_dwelling(start.dwell):
            return time_left(start.dwell) > time
        if start.riding > 0.0:
            contact_force = start.wall * wall_acceleration(start, segment.phase, regime, base)
            change = time * u_derivative_bound(3, segment, base)
            at_rest = contact_force == 0.0 and change == 0.0
            if contact_force <= change and not at_rest:
                return False
        else:
            drift = gap_rate(start, segment.phase) * time
            sag = 0.5 * segment.bounds.u2 * time * time
            if start.gap_order > 0 or start.gap + min(0.0, drift) - sag <= 0.0:
                return False
            if start.gap + max(0.0, drift) + sag >= 2.0 * scene.particle.clearance_ratio:
                return False
    return True


@inlined
def _rubs_on_between(
    segment: Segment, scene: Scene, particle: Particle, friction: float, share: float
) -> bool:
    """`is_free_between` for a particle with friction that stays carried, or keeps sliding and meets no wall."""
    base, start, end, regime = scene.base, segment.start, segment.end, segment.regime
    if start.riding > 0.0:
        sag = share * u_derivative_bound(4, segment, base)
        before = given_to(start, segment.phase, regime, base, particle)
        after = given_to(end, segment.phase_end, regime, base, particle)
        return is_held(start, before, friction, sag) and is_held(end, after, friction, sag)
    sag = share * (segment.bounds.u2 + largest_of(particle))
    if min(start.gap, end.gap) <= sag or max(start.gap, end.gap) + sag >= 2.0 * particle.clearance_ratio:
        return False
    slowest = min(sliding_speed(start, segment.phase), sliding_speed(end, segment.phase_end))
    return slowest > share * u_derivative_bound(3, segment, base)


@inlined
def _rubs_on_from(segment: Segment, scene: Scene, particle: Particle, friction: float) -> bool:
    """`is_free_from` for a particle with friction."""
    base, start, regime, time = scene.base, segment.start, segment.regime, segment.time
    if start.riding > 0.0:
        change = time * u_derivative_bound(3, segment, base)
        return is_held(start, given_to(start, segment.phase, regime, base, particle), friction, change)
    if start.gap_order + order_of(start.slide) > 0:
        return False
    drift = gap_rate(start, segment.phase) * time
    most = segment.bounds.u2 + largest_of(particle)
    sag = 0.5 * most * time * time
    if start.gap + min(0.0, drift) - sag <= 0.0:
        return False
    if start.gap + max(0.0, drift) + sag >= 2.0 * particle.clearance_ratio:
        return False
    return sliding_speed(start, segment.phase) > time * most


@inlined
def given_to(state: State, phase: Phase, regime: Regime, base: Excitation, particle: Particle) -> float:
    """Acceleration that friction or a wall must give to a particle that the mass carries."""
    return without_fall(wall_acceleration(state, phase, regime, base), state.slide, particle)


@inlined
def is_held(state: State, given: float, friction: float, margin: float) -> bool:
    """Whether the mass keeps carrying a particle if the required acceleration changes by less than a margin."""
    if state.gap == 0.0:
        return state.wall * given + friction > margin
    return friction - abs(given) > margin


@inlined
def sliding_speed(state: State, phase: Phase) -> float:
    """|u' − p'| of a particle that slides."""
    return direction_of(state.slide) * ((state.w + phase.rate) - state.p_rate)
