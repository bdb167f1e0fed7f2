"""A compliant wall: from the moment that it is struck to the moment that the particle is clear of it.

The motion in contact is crossed in one of three ways. Before the contact's own vibration has died down, in spans of half a
radian of its fastest rate, as polynomials of all six coordinates. Where an envelope of that vibration proves that it cannot
cause an event, in one leap: the slow motion as polynomials, the vibration by its exponential. And once it has decayed below
rounding, in whole windows, as a particle that rides: so resting on the stiffest wall costs no more than on a rigid one.

The wall lets go where its force falls to zero, with some of the spring's energy left. The particle is then still in the
wall: it flies until it is clear of it, or until spring and dashpot would push again.
"""

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.physics.contact import spring_energy
from damperlab.worker.physics.friction import breakaway, slip_direction
from damperlab.worker.solver.contact.compliant.long_step import FEWEST_STEPS, leap, leapt, set_out, vibration
from damperlab.worker.solver.contact.compliant.segment import expand, to_event
from damperlab.worker.solver.contact.compliant.separation import set_free
from damperlab.worker.solver.contact.release import release
from damperlab.worker.solver.excitation.base import (
    acceleration_scale,
    expand_base,
    phase_after,
    phase_at,
    phase_until,
)
from damperlab.worker.solver.motion.slow_subspace import DIM
from damperlab.worker.solver.state import (
    ARRIVED,
    BUDGET,
    CLEARANCE,
    IDLE,
    IMPACT_LOSS,
    IMPACTS,
    NOTHING,
    OUT_OF_EVENTS,
    RELEASE,
    SEGMENTS,
    SLIP_ONSET,
    SPEED,
    STALLED,
    TURN,
    TURNS,
    Dwell,
    State,
)
from damperlab.worker.solver.state import PUSH as PUSHED
from damperlab.worker.solver.transitions import record_segment, record_transition

_MOST_IDLE = 64  # events without time moving on before the march gives up
_SPEED_ROUNDING = 1e-13  # relative: below this a leaving speed is rounding


@inlined
def is_compliant(wall):
    """Whether walls give way."""
    return wall is not None


@inlined
def in_wall(state, wall):
    """Whether the particle is in a compliant wall, pushed by it or not."""
    if wall is not None:
        return state.riding > 0.0 or state.gap < 0.0
    return False


@kernel
def strike(state, side, phase, base, friction, wall, counts, meter):
    """The particle meets a compliant wall: nothing jumps, but the dashpot pushes at once."""
    if wall is None:
        return state
    u_rate = state.w + phase.rate
    approach = max(side * (u_rate - state.p_rate), 0.0)
    counts[IMPACTS] += 1
    if meter is not None:
        meter.sums[SPEED] = max(meter.sums[SPEED], approach)
    order = 0
    if wall.damping * approach == 0.0:
        order = 1 if approach > 0.0 or wall.damping > 0.0 else 2
    slip = state.slip
    slip_order = 0
    if friction is not None:
        if slip == 0.0:
            slip = _judge(state.v, side * wall.damping * approach, phase, base, friction)
            slip_order = 1 if slip != 0.0 else 0
    return State(
        state.v,
        state.w,
        slip,
        side,
        0.0,
        u_rate - side * approach,
        1.0,
        slip_order,
        order,
        Dwell(0.0, approach),
    )


@kernel
def _judge(v, push, phase, base, friction):
    """Direction in which a mass at rest on the base starts to slip; 0 where friction holds it against the contact too."""
    limit = breakaway(friction, acceleration_scale(base) + abs(push), 1.0)
    return slip_direction(phase.push - v - push, limit)


@kernel
def through_wall(state, wall, phase, left, k, base, free, contact, friction, shaken, counts, meter, log):
    """March a particle that is in a wall to its end, or to the end of the window.

    Parameters
    ----------
    state : State
        Anywhere in window k.
    wall : Wall or None
        None where walls are rigid: nothing is done.
    phase : Phase
        There.
    left : float
        Time to the end of the window.
    shaken : array, shape (TERMS,)
        Filled with the coefficients of the base over the window.

    Returns
    -------
    state : State
    phase : Phase
        There.
    left : float
        0 at the end of the window.
    outcome : int
        ARRIVED, OUT_OF_EVENTS or STALLED.
    """
    if wall is None:
        return state, phase, left, ARRIVED
    opening = phase_at(base, k)
    expand_base(base, opening, shaken)
    while left > 0.0 and in_wall(state, wall):
        before = state
        if state.riding > 0.0:
            state, t, kind = _pressed_on(state, wall, phase, left, base, contact, friction, counts, meter)
        else:
            state, t, kind = set_free(state, wall, phase, left, base, free, contact, friction, meter)
        record_segment(log, before, (k + 1) * base.window - left, t, kind)
        if kind != NOTHING:
            counts[SEGMENTS] += 1
        if counts[SEGMENTS] > counts[BUDGET]:
            return state, phase, left, OUT_OF_EVENTS
        if t <= 1e-15 * contact.slipping.step:
            counts[IDLE] += 1
            if counts[IDLE] > _MOST_IDLE:
                return state, phase, left, STALLED
        else:
            counts[IDLE] = 0
        left = max(left - t, 0.0)
        phase = phase_until(base, k)
        if left > 0.0:
            phase = phase_after(base, opening, shaken, base.window - left)
        reached = state
        if kind != NOTHING:
            state = _pass(state, kind, phase, base, friction, wall, counts, meter)
        record_transition(log, t, kind, reached, state, phase)
    return state, phase, left, ARRIVED


@kernel
def _pressed_on(state, wall, phase, left, base, contact, friction, counts, meter):
    """One segment while the wall pushes: the state at its end, its length, and the event there."""
    buffers = contact.buffers
    held = False
    offset = 0.0
    motion = contact.slipping
    between = contact.slipping_between
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
        if held:
            motion = contact.held
            between = contact.held_between
    start = buffers.start
    set_out(state, offset, held, phase, motion, start)
    expand_base(base, phase, buffers.shaken)
    if motion.fast > 0:
        first, second, settled = vibration(start, motion)
        if not settled and between.fast > 0:
            _, _, follows = vibration(start, between)
            if follows:
                counts[SEGMENTS] += 1
                expand(start, DIM - 1, between.slow_rows, buffers)
                t = min(left, between.slow_step)
                return to_event(state, wall, phase, t, offset, held, base, friction, buffers, meter)
        if settled or left > FEWEST_STEPS * motion.step:
            t = min(left, motion.slow_step)
            if not settled:
                for i in range(DIM):
                    start[i] -= motion.writer[2 * i] * first + motion.writer[2 * i + 1] * second
            expand(start, DIM - motion.fast, motion.slow_rows, buffers)
            if settled:
                return to_event(state, wall, phase, t, offset, held, base, friction, buffers, meter)
            t = leap(
                state, phase, t, offset, held, first, second, wall, base, motion, friction, buffers, meter
            )
            if t > 0.0:
                return leapt(
                    state, t, offset, held, first, second, wall, base, motion, friction, buffers, meter
                )
            set_out(state, offset, held, phase, motion, start)
        counts[SEGMENTS] += 1
    expand(start, DIM, motion.rows, buffers)
    return to_event(state, wall, phase, min(left, motion.step), offset, held, base, friction, buffers, meter)


@kernel
def _pass(state, kind, phase, base, friction, wall, counts, meter):
    """What an event in the wall changes."""
    slip = state.slip
    slip_order = state.slip_order
    order = state.gap_order
    gap = state.gap
    w = state.w
    riding = state.riding
    dwell = state.dwell
    u_rate = w + phase.rate
    leaving = state.wall * (state.p_rate - u_rate)
    if friction is not None:
        if kind in (TURN, SLIP_ONSET):
            push = 0.0
            if riding > 0.0:
                push = state.wall * (wall.damping * dwell.speed - wall.stiffness * gap)
            if kind == TURN:
                counts[TURNS] += 1
                slip = _judge(state.v, push, phase, base, friction)
            else:
                force = phase.push - state.v - push
                slip = 1.0 if force > 0.0 else -1.0
            w = 0.0
            slip_order = 1 if slip != 0.0 else 0
    if kind == RELEASE:
        riding = 0.0
        leaving = -dwell.speed
        if leaving <= _SPEED_ROUNDING * (abs(u_rate) + abs(w) + abs(phase.rate)):
            # the particle came to rest on the wall: how it yields is beyond the digits of the velocities
            if meter is not None:
                if meter.energies is not None:
                    meter.sums[IMPACT_LOSS] += spring_energy(wall.stiffness, -gap)
            return release(state, phase, base, friction)
        dwell = Dwell(0.0, 0.0)
        order = 1
        if wall.damping == 0.0 or gap >= 0.0:
            gap = 0.0
            order = 1 if leaving > 0.0 else 2
    elif kind == CLEARANCE:
        order = 1 if leaving > 0.0 else 2
    elif kind == PUSHED:
        if leaving < 0.0:  # rounding has left the particle a little in the wall that it is about to strike
            return strike(state, state.wall, phase, base, friction, wall, counts, meter)
        if wall.damping == 0.0:
            gap = 0.0
            order = 1 if leaving > 0.0 else 2
        else:
            riding = 1.0
            dwell = Dwell(0.0, gap * wall.stiffness / wall.damping)
            order = 1
    return State(state.v, w, slip, state.wall, gap, state.p_rate, riding, slip_order, order, dwell)
