"""A compliant wall: from the moment that it is struck to the moment that the particle is clear of it.

The motion in contact is crossed in one of three ways. Before the contact's own vibration has died down, in spans of half a
radian of its fastest rate, as polynomials of all six coordinates. Where an envelope of that vibration proves that it cannot
cause an event, in one leap: the slow motion as polynomials, the vibration by its exponential. And once it has decayed below
rounding, in whole windows, as a particle that rides: so resting on the stiffest wall costs no more than on a rigid one.

The wall lets go where its force falls to zero, with some of the spring's energy left. The particle is then still in the
wall: it flies until it is clear of it, or until spring and dashpot would push again.
"""

from math import inf, sqrt

from worker.jit import inlined, kernel
from worker.physics.contact import spring_energy
from worker.physics.friction import breakaway, slip_direction
from worker.solver.crossing import first_crossing
from worker.solver.press_measure import TAME, measure_contact, measure_leap, raise_peaks
from worker.solver.pressed import ABSOLUTE, DEPTH, DIM, PUSH, RELATIVE, combine_rows, fast_later
from worker.solver.record import record
from worker.solver.releasing import release
from worker.solver.scene import (
    ARRIVED,
    BUDGET,
    CLEARANCE,
    IDLE,
    IMPACT_LOSS,
    IMPACTS,
    NOTHING,
    OUT_OF_EVENTS,
    PEAK,
    RELATIVE_PEAK,
    RELEASE,
    SEGMENTS,
    SLIP_ONSET,
    SPEED,
    STALLED,
    STUCK,
    TURN,
    TURNS,
    Dwell,
    State,
)
from worker.solver.scene import PUSH as PUSHED
from worker.solver.shaking import (
    acceleration_scale,
    carry,
    expand_base,
    phase_after,
    phase_at,
    phase_until,
    push_into,
)
from worker.solver.taylor import (
    TERMS,
    change,
    combine,
    curvature_bound,
    rate_into,
    slope,
    stand,
    value,
)

_MOST_IDLE = 64  # events without time moving on before the march gives up
_NOISE = 2e-15  # of f, relative to the terms that it is the difference of
_FEWEST_STEPS = 8.0  # a leap shorter than this many steps is not worth its proof
_SHORTER = 0.125
_NEAR = 1e-6  # share of a span within which a root is looked for first, and by how much wider then
_WIDER = 16.0
_SPEED_ROUNDING = 1e-13  # relative: below this a leaving speed is rounding
_SAFETY = 2.0  # the envelope of f falls exactly only without the coupling to the slow motion


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
            state, t, kind = _set_free(state, wall, phase, left, base, free, contact, friction, meter)
        if log is not None:
            record(log, before, (k + 1) * base.window - left, t, kind)
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
        if kind != NOTHING:
            state = _pass(state, kind, phase, base, friction, wall, counts, meter)
    return state, phase, left, ARRIVED


@kernel
def _pressed_on(state, wall, phase, left, base, contact, friction, counts, meter):
    """One segment while the wall pushes: the state at its end, its length, and the event there."""
    buffers = contact.buffers
    held = False
    offset = 0.0
    motion = contact.slipping
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
        if held:
            motion = contact.held
    start = buffers.start
    set_out(state, offset, held, phase, motion, start)
    expand_base(base, phase, buffers.shaken)
    if motion.fast > 0:
        first, second, settled = vibration(start, motion)
        if settled or left > _FEWEST_STEPS * motion.step:
            t = min(left, motion.slow_step)
            if not settled:
                for i in range(DIM):
                    start[i] -= motion.writer[2 * i] * first + motion.writer[2 * i + 1] * second
            _expand(start, DIM - motion.fast, motion.slow_rows, buffers)
            if settled:
                return _to_event(state, wall, phase, t, offset, held, base, friction, buffers, meter)
            t = _leap(
                state, phase, t, offset, held, first, second, wall, base, motion, friction, buffers, meter
            )
            if t > 0.0:
                return _leapt(
                    state, t, offset, held, first, second, wall, base, motion, friction, buffers, meter
                )
            set_out(state, offset, held, phase, motion, start)
        counts[SEGMENTS] += 1
    _expand(start, DIM, motion.rows, buffers)
    return _to_event(state, wall, phase, min(left, motion.step), offset, held, base, friction, buffers, meter)


@kernel
def set_out(state, offset, held, phase, motion, start):
    """The six coordinates of a state in contact."""
    y = -state.wall * state.gap
    y_rate = state.wall * state.dwell.speed
    start[0] = (state.v + offset) - motion.share * y
    start[1] = 0.0 if held else state.w - motion.share * y_rate
    start[2] = phase.first
    start[3] = phase.second
    start[4] = y
    start[5] = y_rate


@kernel
def vibration(start, motion):
    """The fast part f of the motion, and whether it has died down to the rounding of what it is a difference of."""
    first = 0.0
    second = 0.0
    first_terms = 0.0
    second_terms = 0.0
    for i in range(DIM):
        one = motion.reader[i] * start[i]
        other = motion.reader[DIM + i] * start[i]
        first += one
        second += other
        first_terms += abs(one)
        second_terms += abs(other)
    noise = _NOISE * (motion.weight * first_terms + second_terms)
    settled = sqrt(second * second + (motion.weight * first) ** 2) <= noise
    return first, second, settled


@kernel
def _expand(start, units, rows, buffers):
    combine_rows(RELATIVE, start, units, rows, buffers.relative)
    combine_rows(ABSOLUTE, start, units, rows, buffers.absolute)
    combine_rows(DEPTH, start, units, rows, buffers.depth)
    combine_rows(PUSH, start, units, rows, buffers.push)


@kernel
def _to_event(state, wall, phase, span, offset, held, base, friction, buffers, meter):
    """To the first event on the expanded polynomials of contact, or to the end of the span."""
    relative, depth = buffers.relative, buffers.depth
    t, kind = _friction_event(state, held, phase, span, base, friction, buffers)
    order = state.gap_order
    for i in range(TERMS - order):
        buffers.scratch[i] = buffers.push[i + order]
    for i in range(TERMS - order, TERMS):
        buffers.scratch[i] = 0.0
    found = first_crossing(buffers.scratch, state.wall, 0.0, t, curvature_bound(buffers.scratch, t))
    if found < inf:
        t, kind = found, RELEASE
    v = state.v
    w = 0.0
    if not held:
        v = state.v + change(relative, t)
        w = slope(relative, t)
    y = value(depth, t)
    y_rate = slope(depth, t)
    if meter is not None:
        if meter.energies is not None:
            measure_contact(meter.sums, v - state.v, offset, held, t, wall.damping, base, friction, buffers)
        elif held:
            meter.sums[STUCK] += t
        raise_peaks(meter.sums, offset, t, friction, buffers)
    order = order if t == 0.0 else 0  # two events at once
    end = State(
        v,
        w,
        state.slip,
        state.wall,
        -state.wall * y,
        slope(buffers.absolute, t) - y_rate,
        1.0,
        0,
        order,
        Dwell(0.0, state.wall * y_rate),
    )
    return end, t, kind


@kernel
def _friction_event(state, held, phase, span, base, friction, buffers):
    """When the mass stops, or is torn loose, against the structure and the force of the wall in `buffers.push`."""
    t = span
    kind = NOTHING
    if friction is not None:
        scratch = buffers.scratch
        if held:
            push_into(base, phase, -1.0, scratch)
            for i in range(TERMS):
                scratch[i] += buffers.push[i]
            limit = breakaway(friction, acceleration_scale(base) + abs(buffers.push[0]), 1.0)
            scratch[0] += state.v + limit
            most = curvature_bound(scratch, t)
            found = first_crossing(scratch, 1.0, 0.0, t, most)
            if found < inf:
                t, kind = found, SLIP_ONSET
            scratch[0] -= 2.0 * limit
            found = first_crossing(scratch, -1.0, 0.0, t, most)
            if found < inf:
                t, kind = found, SLIP_ONSET
        else:
            rate_into(buffers.relative, state.slip_order, scratch)
            found = first_crossing(scratch, state.slip, 0.0, t, curvature_bound(scratch, t))
            if found < inf:
                t, kind = found, TURN
    return t, kind


@kernel
def _least(polynomial, sign, t):
    """Lower bound of sign · p over [0, t]: between its ends a function sags by at most t²/8 of its curvature."""
    ends = min(sign * polynomial[0], sign * value(polynomial, t))
    return ends - 0.125 * t * t * curvature_bound(polynomial, t)


@kernel
def _leap(state, phase, span, offset, held, first, second, wall, base, motion, friction, buffers, meter):
    """How far the vibration can be proved to cause no event, 0 where that is not worth a leap; slow motion in `buffers`."""
    size = _SAFETY * sqrt(second * second + (motion.weight * first) ** 2)
    u = motion.writer
    s = motion.share
    k, c = wall.stiffness, wall.damping
    push_most = size * _gain(k * u[8] + c * u[10], k * u[9] + c * u[11], motion.weight)
    if state.wall * buffers.push[0] <= push_most:
        return 0.0
    x_most = size * _gain(u[0] + s * u[8], u[1] + s * u[9], motion.weight)
    w_most = size * _gain(u[2] + s * u[10], u[3] + s * u[11], motion.weight)
    scratch, rate = buffers.scratch, buffers.rate
    limit = 0.0
    if friction is not None:
        if held:
            push_into(base, phase, 1.0, scratch)
            for i in range(TERMS):
                scratch[i] -= buffers.push[i]
            scratch[0] -= state.v
            limit = friction - push_most
        else:
            rate_into(buffers.relative, 0, scratch)
    if meter is not None:
        rate_into(buffers.absolute, 0, rate)
    t = span
    while t > _FEWEST_STEPS * motion.step:
        clear = _least(buffers.push, state.wall, t) > push_most
        if friction is not None:
            if held:
                force = max(-_least(scratch, 1.0, t), -_least(scratch, -1.0, t))
                clear = clear and force < limit
            else:
                clear = clear and _least(scratch, state.slip, t) > w_most
        if meter is not None and clear:
            # whether energies are asked for or not, so that a point has the same bits
            clear = abs(motion.rates[0] + motion.rates[3]) * t >= TAME
            sign = 1.0 if rate[0] > 0.0 else -1.0
            if _least(rate, sign, t) <= w_most:
                u_most = max(abs(buffers.absolute[0] - offset), abs(value(buffers.absolute, t) - offset))
                u_most += 0.125 * t * t * curvature_bound(buffers.absolute, t) + x_most
                clear = clear and u_most <= meter.sums[PEAK]
            if friction is None and clear:
                rate_into(buffers.relative, 0, scratch)
                sign = 1.0 if scratch[0] > 0.0 else -1.0
                if _least(scratch, sign, t) <= w_most:
                    v_most = max(abs(buffers.relative[0]), abs(value(buffers.relative, t)))
                    v_most += 0.125 * t * t * curvature_bound(buffers.relative, t) + x_most
                    clear = v_most <= meter.sums[RELATIVE_PEAK]
        if clear:
            return t
        t *= _SHORTER
    return 0.0


@kernel
def _gain(first, second, weight):
    """Largest value of a linear form of f over its size √(f₂² + Ω²f₁²)."""
    return sqrt((first / weight) ** 2 + second * second)


@kernel
def _leapt(state, t, offset, held, first, second, wall, base, motion, friction, buffers, meter):
    """The state after a leap."""
    one, two = fast_later(motion.rates, first, second, t)
    u = motion.writer
    s = motion.share
    v = state.v
    w = 0.0
    if not held:
        shaken = (u[0] + s * u[8]) * (one - first) + (u[1] + s * u[9]) * (two - second)
        v = state.v + (change(buffers.relative, t) + shaken)
        w = slope(buffers.relative, t) + ((u[2] + s * u[10]) * one + (u[3] + s * u[11]) * two)
    y = value(buffers.depth, t) + (u[8] * one + u[9] * two)
    y_rate = slope(buffers.depth, t) + (u[10] * one + u[11] * two)
    u_rate = w + slope(buffers.shaken, t)
    if meter is not None:
        sums = meter.sums
        if meter.energies is not None:
            measure_contact(sums, v - state.v, offset, held, t, wall.damping, base, friction, buffers)
            measure_leap(sums, offset, held, t, first, second, one, two, wall, base, motion, buffers)
        elif held:
            sums[STUCK] += t
        sums[PEAK] = max(sums[PEAK], max(abs(state.v + buffers.shaken[0]), abs(v + value(buffers.shaken, t))))
        sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], max(abs(state.v), abs(v)))
    end = State(
        v,
        w,
        state.slip,
        state.wall,
        -state.wall * y,
        u_rate - y_rate,
        1.0,
        0,
        0,
        Dwell(0.0, state.wall * y_rate),
    )
    return end, t, NOTHING


@kernel
def _set_free(state, wall, phase, left, base, free, contact, friction, meter):
    """One segment of a particle that the wall has let go while still in it: nothing pulls it."""
    buffers = contact.buffers
    relative, absolute, depth, scratch = buffers.relative, buffers.absolute, buffers.depth, buffers.scratch
    held = False
    offset = 0.0
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
    expand_base(base, phase, buffers.shaken)
    if held:
        expand_base(base, phase, absolute)
        stand(state.v, relative, absolute)
    else:
        combine(state.v + offset, state.w, phase.first, phase.second, free.relative, relative)
        combine(state.v + offset, state.w, phase.first, phase.second, free.absolute, absolute)
        carry(base, phase, absolute)
    for i in range(TERMS):
        buffers.push[i] = 0.0
        depth[i] = state.wall * absolute[i]
    depth[0] = -state.gap
    depth[1] = state.wall * (absolute[1] - state.p_rate)
    t, kind = _friction_event(state, held, phase, left, base, friction, buffers)
    near = 2.0 * depth[0] / -depth[1] if depth[1] < 0.0 else _NEAR * t
    found = _crossing_from(depth, near, t)
    if found < inf:
        t, kind = found, CLEARANCE
    # spring and dashpot push again where K pen + C pen' rises through zero; at the start it may be zero by the release
    order = state.gap_order
    lead = wall.damping / wall.stiffness
    for i in range(TERMS - order):
        n = i + order
        scratch[i] = -depth[n]
        if n + 1 < TERMS:
            scratch[i] -= lead * (n + 1) * depth[n + 1]
    for i in range(TERMS - order, TERMS):
        scratch[i] = 0.0
    found = _crossing_from(scratch, near, t)
    if found < inf:
        t, kind = found, PUSHED
    v = state.v
    w = 0.0
    if not held:
        v = state.v + change(relative, t)
        w = slope(relative, t)
    pen = 0.0 if kind == CLEARANCE else value(depth, t)
    if meter is not None:
        if meter.energies is not None:
            measure_contact(meter.sums, v - state.v, offset, held, t, 0.0, base, friction, buffers)
            lost = spring_energy(wall.stiffness, -state.gap) - spring_energy(wall.stiffness, pen)
            meter.sums[IMPACT_LOSS] += lost
        elif held:
            meter.sums[STUCK] += t
        raise_peaks(meter.sums, offset, t, friction, buffers)
    end = State(v, w, state.slip, state.wall, -pen, state.p_rate, 0.0, 0, 0, Dwell(0.0, 0.0))
    return end, t, kind


@kernel
def _crossing_from(polynomial, near, span):
    """First fall through zero, looked for in spans that grow from `near`.

    The curvature over the whole span would hide a root that is close: out of a stiff wall the particle moves slowly.
    """
    start = 0.0
    end = min(max(near, 1e-15 * span), span)
    while True:
        found = first_crossing(polynomial, 1.0, start, end, curvature_bound(polynomial, end))
        if found < inf or end >= span:
            return found
        start = end
        end = min(_WIDER * end, span)


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
