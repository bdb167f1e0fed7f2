"""Proofs that a segment has no event."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.detection.bounds import u_derivative_bound, w_curvature_bound, w_rate_bound
from damperlab.worker.solver.dwell import is_dwelling, time_left
from damperlab.worker.solver.excitation.excitation import (
    Excitation,
    Phase,
    force_to_hold,
    forcing_derivative_bound,
)
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import Regime, Segment
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import direction_of, fall_of, largest_of, order_of, with_pull
from damperlab.worker.solver.state import State


@inlined
def is_free_between(segment: Segment, scene: Scene) -> bool:
    """Whether bounds prove that a complete panel has no event.

    Each event is a zero of a function f(t). Inside a panel of length h, f(t) ≥ min(f(0), f(h)) − B h²/8,
    where B is a bound on |f''|.
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
            force_start = abs(force_to_hold(segment.phase, v, inertia))
            force_end = abs(force_to_hold(segment.phase_end, v, inertia))
            curvature = forcing_derivative_bound(base, segment.phase, 2, inertia)
            if max(force_start, force_end) + share * curvature >= scene.friction:
                return False
        else:
            sag = share * w_curvature_bound(0, segment, base)
            if min(start.slip * start.w, start.slip * end.w) <= sag:
                return False
    if scene.particle is not None:
        particle = scene.particle
        if is_dwelling(start.dwell):
            return time_left(start.dwell) > window
        if start.riding > 0.0:
            sag = share * u_derivative_bound(4, segment, base)
            before = given_to(start, segment.phase, regime, base, particle)
            after = given_to(end, segment.phase_end, regime, base, particle)
            return stays_carried(start, end, before, after, sag, particle)
        sag = share * (segment.bounds.u2 + largest_of(particle))
        if min(start.gap, end.gap) <= sag or max(start.gap, end.gap) + sag >= 2.0 * particle.clearance_ratio:
            return False
        if particle.friction is not None:
            slowest = min(sliding_speed(start, segment.phase), sliding_speed(end, segment.phase_end))
            return slowest > share * u_derivative_bound(3, segment, base)
    return True


@inlined
def is_free_from(segment: Segment, scene: Scene) -> bool:
    """Whether bounds from the start of a segment prove that the segment has no event."""
    base, start, regime, time = scene.base, segment.start, segment.regime, segment.time
    if scene.friction is not None:
        if regime.sticks:
            inertia = 1.0 / regime.motion.compliance
            v = with_pull(start.v, start, scene.particle)
            force_start = abs(force_to_hold(segment.phase, v, inertia))
            if (
                force_start + forcing_derivative_bound(base, segment.phase, 1, inertia) * time
                >= scene.friction
            ):
                return False
        elif start.slip_order > 0 or abs(start.w) <= time * w_rate_bound(segment, base):
            return False
    if scene.particle is not None:
        particle = scene.particle
        if is_dwelling(start.dwell):
            return time_left(start.dwell) > time
        if start.riding > 0.0:
            change = time * u_derivative_bound(3, segment, base)
            given = given_to(start, segment.phase, regime, base, particle)
            return stays_carried(start, start, given, given, change, particle)
        if start.gap_order + order_of(start.slide) > 0:
            return False
        drift = start.wall * (start.p_rate - (start.w + segment.phase.rate)) * time
        bent = segment.bounds.u2 + largest_of(particle)
        sag = 0.5 * bent * time * time
        if start.gap + min(0.0, drift) - sag <= 0.0:
            return False
        if start.gap + max(0.0, drift) + sag >= 2.0 * particle.clearance_ratio:
            return False
        if particle.friction is not None:
            return sliding_speed(start, segment.phase) > time * bent
    return True


@inlined
def given_to(state: State, phase: Phase, regime: Regime, base: Excitation, particle: Particle) -> float:
    """Acceleration that friction or a wall must give to a particle that the mass carries."""
    u_acceleration = -phase.inertia_force
    if not regime.sticks:
        resistance = base.two_zeta * state.w + state.v + regime.offset - phase.force
        u_acceleration = -regime.motion.compliance * resistance
    return u_acceleration - fall_of(state.slide, particle)


@inlined
def stays_carried(
    start: State, end: State, before: float, after: float, margin: float, particle: Particle
) -> bool:
    """Whether the mass carries a particle from one state to another, given the required accelerations at both states.

    Without friction, only a pushing wall carries the particle. If nothing moves, a particle at rest on its wall stays
    there.
    """
    if particle.friction is not None:
        rubs = particle.friction
        return is_held(start, before, rubs, margin) and is_held(end, after, rubs, margin)
    pushes, pushes_after = start.wall * before, start.wall * after
    at_rest = pushes == 0.0 and pushes_after == 0.0 and margin == 0.0
    return at_rest or not min(pushes, pushes_after) <= margin


@inlined
def is_held(state: State, given: float, friction: float, margin: float) -> bool:
    """Whether the mass keeps carrying a particle while the required acceleration changes by at most `margin`."""
    if state.gap == 0.0:
        return state.wall * given + friction > margin
    return friction - abs(given) > margin


@inlined
def sliding_speed(state: State, phase: Phase) -> float:
    """|u' − p'| of a particle that slides."""
    return direction_of(state.slide) * ((state.w + phase.rate) - state.p_rate)
