"""What an event changes: slip, contact and velocities just after it, decided together so that they are consistent."""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway, hold_force, slip_direction
from damperlab.worker.physics.impact import impact_loss, part, rebound
from damperlab.worker.solver.contact.compliant.phase import is_compliant, strike
from damperlab.worker.solver.contact.release import release
from damperlab.worker.solver.dwell import approach_speed, is_brief, is_dwelling, no_dwell
from damperlab.worker.solver.excitation.base import acceleration_scale
from damperlab.worker.solver.state import (
    ATTACHMENTS,
    FAR_WALL,
    IMPACT_LOSS,
    IMPACTS,
    LET_GO,
    NEAR_WALL,
    RELEASE,
    SLIP_ONSET,
    SPEED,
    TURN,
    TURNS,
    Dwell,
    State,
)

# A chatter is cut short when what is left of it takes less than this share of a window. Joining the bodies then conserves
# momentum, so the error is (time left)² × acceleration: below 1e-17 of the motion, less than rounding.
_CHATTER_LEFT = 1e-8
_FEWEST_LOSS = 1e-3  # of speed an impact
_SPEED_ROUNDING = 1e-14  # relative: below this an outgoing speed is rounding


@inlined
def pass_event(state, kind, phase, base, friction, particle, counts, meter):
    """What the event changes: one transition, after which slip, contact and their orders are consistent again."""
    if friction is not None:
        if kind == TURN:
            counts[TURNS] += 1
            return _come_to_rest(state, phase, base, friction, particle)
        if kind == SLIP_ONSET:
            inertia = 1.0
            if particle is not None:
                if state.riding > 0.0:
                    inertia = 1.0 + particle.mass_ratio
            force = hold_force(state.v, phase.push, inertia)
            slip = 1.0 if force > 0.0 else -1.0
            return State(
                state.v, 0.0, slip, state.wall, state.gap, state.p_rate, state.riding, 1, 0, state.dwell
            )
    if particle is not None:
        if kind == RELEASE:
            return release(state, phase, base, friction)
        if kind in (NEAR_WALL, FAR_WALL):
            wall = state.wall if kind == NEAR_WALL else -state.wall
            if is_compliant(particle.wall):
                return strike(state, wall, phase, base, friction, particle.wall, counts, meter)
            return _impact(
                state,
                wall,
                phase,
                base,
                friction,
                particle,
                particle.contact_time,
                counts,
                meter,
            )
        if kind == LET_GO:
            return _let_go(state, phase, base, friction, particle, particle.contact_time, counts, meter)
    return state


@inlined
def _come_to_rest(state, phase, base, friction, particle):
    """The mass has come to rest on the base: it sticks, or slips on or back, alone or with the particle on its wall.

    With the particle in contact the free alternative is tried first: where the wall would then run away from the particle
    it is released, otherwise it rides, and friction is judged with both masses. Exactly one of the two is consistent.
    A particle that dwells on its wall has no such choice.
    """
    most = acceleration_scale(base)
    slip = slip_direction(hold_force(state.v, phase.push, 1.0), breakaway(friction, most, 1.0))
    riding = 0.0
    gap_order = 0
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = phase.rate
            free_acceleration = -phase.push if slip == 0.0 else -(state.v + slip * friction)
            if state.wall * free_acceleration >= 0.0 or is_dwelling(state.dwell):
                riding = 1.0
                inertia = 1.0 + particle.mass_ratio
                force = hold_force(state.v, phase.push, inertia)
                slip = slip_direction(force, breakaway(friction, most, inertia))
            else:
                gap_order = 2
    slip_order = 0 if slip == 0.0 else 1
    return State(
        state.v, 0.0, slip, state.wall, state.gap, p_rate, riding, slip_order, gap_order, state.dwell
    )


@inlined
def _impact(state, wall, phase, base, friction, particle, contact_time, counts, meter):
    """An impact on the given wall, and what follows at once: a flight, riding on the wall, or being held there."""
    u_rate = state.w + phase.rate
    approach = max(wall * (u_rate - state.p_rate), 0.0)
    counts[IMPACTS] += 1
    if meter is not None:
        meter.sums[SPEED] = max(meter.sums[SPEED], approach)
        if meter.energies is not None:
            meter.sums[IMPACT_LOSS] += impact_loss(approach, particle.restitution, particle.mass_ratio)
    before = u_rate - wall * approach
    if contact_time is not None:
        # a touch at a speed that is rounding begins no contact: it would hold the particle for the whole contact time
        if approach > _SPEED_ROUNDING * (abs(u_rate) + abs(state.p_rate) + abs(phase.rate)):
            jump, p_rate = rebound(u_rate, before, 0.0, particle.mass_ratio)
            dwell = Dwell(contact_time, approach)
            return _join(state, wall, state.w + jump, p_rate, phase, base, friction, particle, dwell)
    jump, p_rate = rebound(u_rate, before, particle.restitution, particle.mass_ratio)
    leaving = particle.restitution * approach
    return _leave(
        state,
        wall,
        state.w + jump,
        p_rate,
        leaving,
        u_rate,
        phase,
        base,
        friction,
        particle,
        contact_time,
        counts,
        meter,
    )


@inlined
def _let_go(state, phase, base, friction, particle, contact_time, counts, meter):
    """The contact time is over: the particle leaves with e times its approach speed, or rides on."""
    if contact_time is None:
        return state
    u_rate = state.w + phase.rate
    leaving = particle.restitution * approach_speed(state.dwell)
    jump, p_jump = part(state.wall * leaving, particle.mass_ratio)
    if friction is not None:
        if state.w + jump == 0.0:  # without a push friction judges anew, as for a particle that rides
            riding = State(
                state.v,
                0.0,
                0.0,
                state.wall,
                0.0,
                u_rate,
                1.0,
                0,
                0,
                no_dwell(state.dwell),
            )
            return _come_to_rest(riding, phase, base, friction, particle)
    return _leave(
        state,
        state.wall,
        state.w + jump,
        u_rate + p_jump,
        leaving,
        u_rate,
        phase,
        base,
        friction,
        particle,
        contact_time,
        counts,
        meter,
    )


@inlined
def _leave(
    state,
    wall,
    w,
    p_rate,
    leaving,
    u_rate_before,
    phase,
    base,
    friction,
    particle,
    contact_time,
    counts,
    meter,
):
    """The particle leaves a wall with a relative speed: a flight, or riding on the wall when the chatter is over."""
    slip = state.slip
    held = False
    offset = 0.0
    if friction is not None:
        if w != 0.0:
            slip = 1.0 if w > 0.0 else -1.0
        held = slip == 0.0
        offset = slip * friction
    u_acceleration = -phase.push if held else -(base.two_zeta * w + state.v + offset)
    closing = wall * u_acceleration  # rate at which the wall catches up with the particle
    rounding = _SPEED_ROUNDING * (abs(u_rate_before) + abs(p_rate) + abs(phase.rate))
    # the flights left shrink by e each; without loss (e = 1) they need friction to shrink, and get no better bound
    impulse_left = 2.0 * leaving / max(1.0 - particle.restitution, _FEWEST_LOSS)
    if leaving == 0.0 and closing == 0.0:
        # a tie: the sign of the change of the wall's acceleration decides, which the search for a release looks at
        closing = rounding
        leaving = 0.0
    short = impulse_left <= _CHATTER_LEFT * base.window * closing
    # contacts that take time go on for as long as their speed is no rounding: each holds the particle anew
    short = short and is_brief(contact_time, _CHATTER_LEFT * base.window)
    dwell = no_dwell(state.dwell)
    if closing > 0.0 and (short or leaving <= rounding):
        counts[ATTACHMENTS] += 1
        jump, p_rate = rebound(w + phase.rate, p_rate, 0.0, particle.mass_ratio)
        if meter is not None:
            if meter.energies is not None:
                meter.sums[IMPACT_LOSS] += impact_loss(leaving, 0.0, particle.mass_ratio)
        return _join(state, wall, w + jump, p_rate, phase, base, friction, particle, dwell)
    return State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, 1 if leaving > 0.0 else 2, dwell)


@inlined
def _join(state, wall, w, p_rate, phase, base, friction, particle, dwell):
    """Particle and primary mass move on together at the velocity w relative to the base."""
    slip = state.slip
    if friction is not None:
        if w != 0.0:
            slip = 1.0 if w > 0.0 else -1.0
        else:
            inertia = 1.0 + particle.mass_ratio
            limit = breakaway(friction, acceleration_scale(base), inertia)
            force = hold_force(state.v, phase.push, inertia)
            slip = slip_direction(force, limit)
            return State(state.v, 0.0, slip, wall, 0.0, p_rate, 1.0, 1 if slip != 0.0 else 0, 0, dwell)
    return State(state.v, w, slip, wall, 0.0, p_rate, 1.0, 0, 0, dwell)
