"""Transition at an event: consistent slip, contact and velocities just after the event."""

from typing import NamedTuple

from damperlab.worker.jit import inlined
from damperlab.worker.physics.impact import impact_loss, part, rebound
from damperlab.worker.solver.contact.chatter import is_chatter_over
from damperlab.worker.solver.contact.compliant.contact_phase import strike
from damperlab.worker.solver.contact.reset_map_sliding import after_event_of_rubbing
from damperlab.worker.solver.contact.rest import (
    SPEED_ROUNDING,
    acceleration_alone,
    detach,
    meet,
    slip_at,
    slip_from_rest,
)
from damperlab.worker.solver.dwell import approach_speed, is_dwelling, no_dwell
from damperlab.worker.solver.events import (
    ATTACHMENTS,
    FAR_WALL,
    LET_GO,
    NEAR_WALL,
    RELEASE,
    SLIP_ONSET,
    TURN,
    TURNS,
)
from damperlab.worker.solver.excitation.excitation import Phase
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State


@inlined
def after_event(state: State, kind: int, phase: Phase, scene: Scene, meter: Meter | None) -> State:
    """The state just after an event, with consistent slip, contact, `slip_order` and `gap_order`."""
    if scene.particle is not None:
        if scene.particle.friction is not None:
            rubs = scene.particle.friction
            return after_event_of_rubbing(state, kind, phase, scene, scene.particle, rubs, meter)
    if scene.friction is not None:
        if kind == TURN:
            scene.counts[TURNS] += 1
            return _come_to_rest(state, phase, scene)
        if kind == SLIP_ONSET:
            inertia = 1.0
            if scene.particle is not None:
                if state.riding > 0.0:
                    inertia = 1.0 + scene.particle.mass_ratio
            slip = slip_from_rest(state.v, 0.0, inertia, True, phase, scene)
            return state._replace(w=0.0, slip=slip, slip_order=int(slip != 0.0), gap_order=0)
    if scene.particle is not None:
        if kind == RELEASE:
            return detach(state, phase, scene)
        if kind in (NEAR_WALL, FAR_WALL):
            wall = state.wall if kind == NEAR_WALL else -state.wall
            if scene.particle.wall is not None:
                return strike(state, wall, phase, scene, meter)
            return _impact(state, wall, phase, scene, scene.particle, meter)
        if kind == LET_GO and scene.particle.contact_time is not None:
            return _let_go(state, phase, scene, scene.particle, meter)
    return state


@inlined
def _come_to_rest(state: State, phase: Phase, scene: Scene) -> State:
    """Return the state after the mass comes to rest on the base: sticking, slipping on or slipping back.

    If the particle is on a wall, a detachment is tried first. If the wall would then move away from the particle, the
    particle detaches. Otherwise the particle stays on the wall, and friction acts on both masses together. Exactly one
    of these cases is consistent. A particle that dwells on its wall cannot detach.
    """
    slip = slip_from_rest(state.v, 0.0, 1.0, False, phase, scene)
    riding = 0.0
    gap_order = 0
    p_rate = state.p_rate
    if scene.particle is not None:
        if state.riding > 0.0:
            p_rate = phase.rate
            acceleration = acceleration_alone(state.v, 0.0, slip, phase, scene)
            if state.wall * acceleration >= 0.0 or is_dwelling(state.dwell):
                riding = 1.0
                slip = slip_from_rest(state.v, 0.0, 1.0 + scene.particle.mass_ratio, False, phase, scene)
            else:
                gap_order = 2
    return state._replace(
        w=0.0, slip=slip, p_rate=p_rate, riding=riding, slip_order=int(slip != 0.0), gap_order=gap_order
    )


@inlined
def _impact(
    state: State, wall: float, phase: Phase, scene: Scene, particle: Particle, meter: Meter | None
) -> State:
    """Return the state just after an impact on the given wall: a flight, sustained contact, or a dwell."""
    u_rate = state.w + phase.rate
    approach, is_impact = meet(state, wall, phase, scene, meter)
    if meter is not None:
        if meter.energies is not None:
            meter.sums[IMPACT_LOSS] += impact_loss(approach, particle.restitution, particle.mass_ratio)
    before = u_rate - wall * approach
    if particle.contact_time is not None:
        # a touch within rounding starts no dwell, which would hold the particle for the contact time
        if is_impact:
            jump, p_rate = rebound(u_rate, before, 0.0, particle.mass_ratio)
            dwell = Dwell(particle.contact_time, approach)
            return _join(state, wall, state.w + jump, p_rate, dwell, phase, scene)
    jump, p_rate = rebound(u_rate, before, particle.restitution, particle.mass_ratio)
    parting = Parting(wall, state.w + jump, p_rate, particle.restitution * approach, u_rate)
    return _part(state, parting, phase, scene, particle, meter)


@inlined
def _let_go(state: State, phase: Phase, scene: Scene, particle: Particle, meter: Meter | None) -> State:
    """Return the state after the contact time: the particle leaves with e times its approach speed, or stays."""
    u_rate = state.w + phase.rate
    leaving = particle.restitution * approach_speed(state.dwell)
    jump, p_jump = part(state.wall * leaving, particle.mass_ratio)
    if scene.friction is not None:
        # a particle that leaves without relative speed remains in contact, so friction is determined again
        if leaving == 0.0 and state.w + jump == 0.0:
            joined = state._replace(gap=0.0, riding=1.0, dwell=no_dwell(state.dwell))
            return _come_to_rest(joined, phase, scene)
    parting = Parting(state.wall, state.w + jump, u_rate + p_jump, leaving, u_rate)
    return _part(state, parting, phase, scene, particle, meter)


class Parting(NamedTuple):
    """Mass and particle just after separation.

    Attributes
    ----------
    wall : float
        The wall that the particle leaves.
    w, p_rate : float
        Velocity of the mass relative to the base, and absolute velocity of the particle.
    speed : float
        Speed of separation [Z ω_n].
    u_rate_before : float
        Absolute velocity of the mass just before the separation, a reference for rounding errors.
    """

    wall: float
    w: float
    p_rate: float
    speed: float
    u_rate_before: float


@inlined
def _part(
    state: State, parting: Parting, phase: Phase, scene: Scene, particle: Particle, meter: Meter | None
) -> State:
    """Return the state after the particle leaves a wall: a flight, or sustained contact if a chatter is complete."""
    wall, w, p_rate, leaving, u_rate_before = parting
    slip = slip_at(w, state.slip, scene)
    u_acceleration = acceleration_alone(state.v, w, slip, phase, scene)
    closing = wall * u_acceleration  # acceleration of the wall towards the particle
    rounding = SPEED_ROUNDING * (abs(u_rate_before) + abs(p_rate) + abs(phase.rate))
    if leaving == 0.0 and closing == 0.0:
        # Without relative speed and acceleration, the particle attaches.
        # The next search for a detachment uses the time derivative of the acceleration.
        closing = rounding
    dwell = no_dwell(state.dwell)
    is_over = is_chatter_over(w, leaving, u_acceleration, closing, scene, particle)
    if closing > 0.0 and (is_over or leaving <= rounding):
        scene.counts[ATTACHMENTS] += 1
        jump, p_rate = rebound(w + phase.rate, p_rate, 0.0, particle.mass_ratio)
        if meter is not None:
            if meter.energies is not None:
                meter.sums[IMPACT_LOSS] += impact_loss(leaving, 0.0, particle.mass_ratio)
        return _join(state, wall, w + jump, p_rate, dwell, phase, scene)
    gap_order = 1 if leaving > 0.0 else 2
    return state._replace(
        w=w,
        slip=slip,
        wall=wall,
        gap=0.0,
        p_rate=p_rate,
        riding=0.0,
        slip_order=0,
        gap_order=gap_order,
        dwell=dwell,
    )


@inlined
def _join(
    state: State, wall: float, w: float, p_rate: float, dwell: Dwell | None, phase: Phase, scene: Scene
) -> State:
    """Return the state of mass and particle that move on together, with velocity w relative to the base."""
    slip = slip_at(w, state.slip, scene)
    slip_order = 0
    if scene.friction is not None and scene.particle is not None:
        if w == 0.0:
            slip = slip_from_rest(state.v, 0.0, 1.0 + scene.particle.mass_ratio, False, phase, scene)
            slip_order = int(slip != 0.0)
    return state._replace(
        w=w,
        slip=slip,
        wall=wall,
        gap=0.0,
        p_rate=p_rate,
        riding=1.0,
        slip_order=slip_order,
        gap_order=0,
        dwell=dwell,
    )
