"""March through half an excitation cycle, from event to event.

What a scene lacks is None here, and the compiler drops it: without `friction` there is no search for turns and no stick,
without `particle` no gap, no impact, no riding; without `meter` no energies and no peaks; without `log` no history.
"""

from math import inf

from worker.jit import kernel
from worker.physics.friction import breakaway, hold_force, slip_direction
from worker.physics.impact import impact_loss, part, rebound
from worker.solver.bounds import motion_bounds, u_bend, w_bend
from worker.solver.crossing import first_crossing
from worker.solver.dwell import (
    approach_speed,
    dwell_on,
    is_brief,
    is_dwelling,
    no_dwell,
    time_left,
)
from worker.solver.measure import find_peaks, measure_segment, measure_window, peaks_at_ends
from worker.solver.memory import address
from worker.solver.record import record
from worker.solver.scene import (
    ARRIVED,
    ATTACHMENTS,
    BUDGET,
    FAR_WALL,
    IDLE,
    IMPACT_LOSS,
    IMPACTS,
    LET_GO,
    NEAR_WALL,
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
from worker.solver.taylor import (
    TERMS,
    acceleration_into,
    bend,
    change,
    combine,
    expand_base,
    expand_stick,
    rate_into,
    slope,
    value,
)
from worker.solver.windows import point_base, point_medium

# A chatter is cut short when what is left of it takes less than this share of a window. Joining the bodies then conserves
# momentum, so the error is (time left)² × acceleration: below 1e-17 of the motion, less than rounding.
_CHATTER_LEFT = 1e-8
_FEWEST_LOSS = 1e-3  # of speed an impact
_SPEED_ROUNDING = 1e-14  # relative: below this an outgoing speed is rounding
# Bound on the second derivative of p(t)/t^k over that on the (k + 2)th of p: 2/(k + 2)!.
_DROPPED = (1.0, 1.0 / 3.0, 1.0 / 12.0, 1.0 / 60.0)
_MOST_IDLE = 64  # events without time moving on before the march gives up


@kernel
def half_cycle(
    state, base_arrays, free_arrays, loaded_arrays, friction, particle, work, count_array, meter_array, log
):
    """March a state through half an excitation cycle and mirror it.

    Parameters
    ----------
    state : State
        At phase 0 of the (mirrored) base.
    base, free : Base, Medium
        The base and the motion of the primary mass alone.
    loaded : Medium or None
        The motion with the particle riding; None without a particle.
    friction : float or None
        γ_F.
    particle : Particle or None
        The particle.
    work : array, shape (4, TERMS)
        Scratch.
    counts : int64 array, shape (COUNTS,)
        Counts, added to; counts[BUDGET] is the largest number of segments allowed.
    meter : float64 array, shape (METERS,), or None
        Added to, where given.
    log : Log or None
        Takes every segment, where given.

    Returns
    -------
    state : State
        Half a cycle later, mirrored: all signs flipped, so that it starts at phase 0 again.
    outcome : int
        ARRIVED, OUT_OF_EVENTS or STALLED.
    """
    base = point_base(base_arrays)
    free = point_medium(free_arrays)
    loaded = None
    if particle is not None:
        loaded = point_medium(loaded_arrays)
    counts = address(count_array, 0)
    meter = None
    if meter_array is not None:
        meter = address(meter_array, 0)
    relative = address(work, 0)
    absolute = address(work, TERMS)
    scratch = address(work, 2 * TERMS)
    shaken = address(work, 3 * TERMS)
    r = base.frequency_ratio
    for k in range(base.windows):
        sine = base.sine[k]
        cosine = base.cosine[k]
        left = base.window
        whole = True
        while True:
            held = False
            offset = 0.0
            if friction is not None:
                held = state.slip == 0.0
                offset = state.slip * friction
            medium = free
            if particle is not None:
                if state.riding > 0.0:
                    medium = loaded
            _x_most, w_most, u2_most = _most(state, offset, held, left, base, medium)
            quiet = False
            if whole:
                # most windows: cross by matrix first, and let both ends together prove that nothing happened between
                crossed = _glide(state, offset, held, base, medium, k, particle)
                quiet = _was_quiet(
                    state,
                    crossed,
                    offset,
                    held,
                    sine,
                    base.sine[k + 1],
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    w_most,
                    u2_most,
                )
                if quiet and log is None:
                    if meter is None:
                        state = crossed
                        break
                    if peaks_at_ends(
                        meter, state, crossed, sine, base.sine[k + 1], left, u2_most, friction, r
                    ):
                        measure_window(
                            meter, state, crossed, offset, held, sine, cosine, base, medium, friction
                        )
                        state = crossed
                        break
            else:
                quiet = _is_quiet(
                    state,
                    offset,
                    held,
                    sine,
                    cosine,
                    left,
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    w_most,
                    u2_most,
                )
            if held:
                expand_stick(state.v, sine, cosine, base.rows, relative, absolute)
            else:
                combine(state.v + offset, state.w, sine, cosine, medium.relative, relative)
                if particle is not None or meter is not None:
                    combine(state.v + offset, state.w, sine, cosine, medium.absolute, absolute)
            t = left
            kind = NOTHING
            if not quiet:
                t, kind = _next_event(
                    state,
                    held,
                    sine,
                    cosine,
                    left,
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    relative,
                    absolute,
                    scratch,
                    w_most,
                    u2_most,
                )
            crossed = _coast(state, offset, held, t, particle, relative, absolute)
            if meter is not None:
                sine_end = base.sine[k + 1]
                if whole and kind == NOTHING:
                    measure_window(meter, state, crossed, offset, held, sine, cosine, base, medium, friction)
                else:
                    expand_base(sine, cosine, base.rows, shaken)
                    sine_end = value(shaken, t)
                    measure_segment(
                        meter, crossed.v - state.v, offset, held, t, base, medium, friction, relative, shaken
                    )
                if not peaks_at_ends(meter, state, crossed, sine, sine_end, t, u2_most, friction, r):
                    find_peaks(
                        meter,
                        state,
                        crossed,
                        sine,
                        sine_end,
                        offset,
                        held,
                        t,
                        base,
                        medium,
                        friction,
                        relative,
                        absolute,
                        scratch,
                        w_most,
                        u2_most,
                    )
            if log is not None:
                record(log, state, (k + 1) * base.window - left, t, kind)
            state = crossed
            if kind == NOTHING:
                break
            counts[SEGMENTS] += 1
            if counts[SEGMENTS] > counts[BUDGET]:
                return state, OUT_OF_EVENTS
            if t <= 1e-15 * base.window:
                counts[IDLE] += 1
                if counts[IDLE] > _MOST_IDLE:
                    return state, STALLED
            else:
                counts[IDLE] = 0
            if meter is None:
                expand_base(sine, cosine, base.rows, shaken)
            sine = value(shaken, t)
            cosine = slope(shaken, t) / r
            left = left - t
            whole = False
            state = _pass_event(state, kind, sine, cosine, base, friction, particle, counts, meter)
            if left <= 0.0:
                break
    return (
        State(
            -state.v,
            -state.w,
            -state.slip,
            -state.wall,
            state.gap,
            -state.p_rate,
            state.riding,
            state.slip_order,
            state.gap_order,
            state.dwell,
        ),
        ARRIVED,
    )


@kernel
def _gap_rate(state, cosine, frequency_ratio):
    """Rate at which the particle leaves the wall last touched."""
    return state.wall * (state.p_rate - (state.w + frequency_ratio * cosine))


@kernel
def _most(state, offset, held, span, base, medium):
    """Bounds on |x|, |w| and |u''| over the span."""
    if held:
        return abs(state.v), 0.0, base.frequency_ratio * base.frequency_ratio
    return motion_bounds(
        state.v + offset, state.w, span, base.two_zeta, medium.compliance, base.frequency_ratio
    )


@kernel
def _was_quiet(
    start, end, offset, held, sine, sine_end, base, medium, friction, particle, dwell, w_most, u2_most
):
    """Whether a window crossed by its matrix held no event: none of the functions whose zeros are events can have one.

    Between its ends a function is at least the smaller of the two less span²/8 times its curvature.
    """
    r = base.frequency_ratio
    r2 = r * r
    share = 0.125 * base.window * base.window
    if start.slip_order + start.gap_order > 0:
        return False
    if friction is not None:
        if held:
            inertia = 1.0 / medium.compliance
            force = abs(hold_force(start.v, r2 * sine, inertia))
            force_end = abs(hold_force(start.v, r2 * sine_end, inertia))
            if max(force, force_end) + share * inertia * r2 * r2 >= friction:
                return False
        else:
            most = share * w_bend(0, w_most, u2_most, base.two_zeta, medium.compliance, r)
            if min(start.slip * start.w, start.slip * end.w) <= most:
                return False
    if particle is not None:
        if is_dwelling(dwell):
            return time_left(dwell) > base.window
        if start.riding > 0.0:
            most = share * u_bend(4, held, w_most, u2_most, base.two_zeta, medium.compliance, r)
            push = -r2 * sine
            push_end = -r2 * sine_end
            if not held:
                push = -medium.compliance * (base.two_zeta * start.w + start.v + offset)
                push_end = -medium.compliance * (base.two_zeta * end.w + end.v + offset)
            if min(start.wall * push, start.wall * push_end) <= most:
                return False
        else:
            most = share * u2_most
            if min(start.gap, end.gap) <= most:
                return False
            if max(start.gap, end.gap) + most >= 2.0 * particle.clearance_ratio:
                return False
    return True


@kernel
def _is_quiet(
    state, offset, held, sine, cosine, span, base, medium, friction, particle, dwell, w_most, u2_most
):
    """Whether bounds alone prove that no event lies in the span; False means that one must look."""
    r = base.frequency_ratio
    r2 = r * r
    if friction is not None:
        if held:
            inertia = 1.0 / medium.compliance
            if abs(hold_force(state.v, r2 * sine, inertia)) + inertia * r2 * r * span >= friction:
                return False
        elif state.slip_order > 0 or abs(state.w) <= span * (u2_most + r2):
            return False
    if particle is not None:
        if is_dwelling(dwell):
            return time_left(dwell) > span
        if state.riding > 0.0:
            jerk_most = r2 * r
            acceleration = -r2 * sine
            if not held:
                jerk_most = medium.compliance * (base.two_zeta * (u2_most + r2) + w_most)
                acceleration = -medium.compliance * (base.two_zeta * state.w + state.v + offset)
            if state.wall * acceleration <= span * jerk_most:
                return False
        else:
            drift = _gap_rate(state, cosine, r) * span
            sag = 0.5 * u2_most * span * span
            if state.gap_order > 0 or state.gap + min(0.0, drift) - sag <= 0.0:
                return False
            if state.gap + max(0.0, drift) + sag >= 2.0 * particle.clearance_ratio:
                return False
    return True


@kernel
def _glide(state, offset, held, base, medium, k, particle):
    """Cross window k, in which nothing happens, by its matrix."""
    v = state.v
    w = 0.0
    if not held:
        x = state.v + offset
        sine = base.sine[k]
        cosine = base.cosine[k]
        v = (medium.xx * x + medium.xw * state.w) + (medium.xs * sine + medium.xc * cosine) - offset
        w = (medium.wx * x + medium.ww * state.w) + (medium.ws * sine + medium.wc * cosine)
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = w + base.frequency_ratio * base.cosine[k + 1]
        else:
            moved = (v - state.v) + (base.sine[k + 1] - base.sine[k])
            gap = state.gap + state.wall * (state.p_rate * base.window - moved)
    dwell = dwell_on(state.dwell, base.window)
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0, dwell)


@kernel
def _coast(state, offset, held, t, particle, relative, absolute):
    """State a time t later on the expanded polynomials."""
    v = state.v
    w = 0.0
    if not held:
        v = state.v + change(relative, t)
        w = slope(relative, t)
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = slope(absolute, t)
        else:
            # the gap's own change, no difference of large displacements
            gap = state.gap + state.wall * ((state.p_rate - absolute[1]) * t - bend(absolute, t))
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0, dwell_on(state.dwell, t))


@kernel
def _next_event(
    state,
    held,
    sine,
    cosine,
    span,
    base,
    medium,
    friction,
    particle,
    dwell,
    relative,
    absolute,
    scratch,
    w_most,
    u2_most,
):
    """Time and kind of the first event within the span, (span, NOTHING) where there is none."""
    r = base.frequency_ratio
    r2 = r * r
    inertia = 1.0 / medium.compliance
    t = span
    kind = NOTHING
    if friction is not None:
        if held:
            for i in range(TERMS):
                scratch[i] = -inertia * r2 * (sine * base.rows[i] + cosine * base.rows[TERMS + i])
            force_bend = inertia * r2 * r2
            limit = breakaway(friction, r2, inertia)
            scratch[0] += state.v + limit
            found = first_crossing(scratch, 1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, SLIP_ONSET
            scratch[0] -= 2.0 * limit
            found = first_crossing(scratch, -1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, SLIP_ONSET
        elif state.slip_order > 0 or abs(state.w) <= span * (u2_most + r2):
            order = state.slip_order
            rate_into(relative, order, scratch)
            most = w_bend(order, w_most, u2_most, base.two_zeta, medium.compliance, r)
            found = first_crossing(scratch, state.slip, 0.0, t, most)
            if found < inf:
                t, kind = found, TURN
    if particle is not None:
        if is_dwelling(dwell):
            if time_left(dwell) <= t:
                t, kind = time_left(dwell), LET_GO
        elif state.riding > 0.0:
            acceleration_into(absolute, scratch)
            most = u_bend(4, held, w_most, u2_most, base.two_zeta, medium.compliance, r)
            found = first_crossing(scratch, state.wall, 0.0, t, most)
            if found < inf:
                t, kind = found, RELEASE
        else:
            order = state.gap_order
            rate = state.wall * (state.p_rate - absolute[1])
            sag = 0.5 * u2_most * t * t
            if order > 0 or state.gap + min(0.0, rate * t) - sag <= 0.0:
                for i in range(TERMS):
                    scratch[i] = 0.0
                for i in range(max(2 - order, 0), TERMS - order):
                    scratch[i] = -state.wall * absolute[i + order]
                if order < 2:
                    scratch[1 - order] = rate
                if order < 1:
                    scratch[0] = state.gap
                found = first_crossing(
                    scratch,
                    1.0,
                    0.0,
                    t,
                    u_bend(2 + order, held, w_most, u2_most, base.two_zeta, medium.compliance, r)
                    * _DROPPED[order],
                )
                if found < inf:
                    t, kind = found, NEAR_WALL
            if state.gap + max(0.0, rate * t) + sag >= 2.0 * particle.clearance_ratio:
                for i in range(2, TERMS):
                    scratch[i] = -state.wall * absolute[i]
                scratch[1] = rate
                scratch[0] = state.gap - 2.0 * particle.clearance_ratio
                found = first_crossing(scratch, -1.0, 0.0, t, u2_most)
                if found < inf:
                    t, kind = found, FAR_WALL
    return t, kind


@kernel
def _pass_event(state, kind, sine, cosine, base, friction, particle, counts, meter):
    """What the event changes: one transition, after which slip, contact and their orders are consistent again."""
    if friction is not None:
        if kind == TURN:
            counts[TURNS] += 1
            return _come_to_rest(state, sine, cosine, base, friction, particle)
        if kind == SLIP_ONSET:
            inertia = 1.0
            if particle is not None:
                if state.riding > 0.0:
                    inertia = 1.0 + particle.mass_ratio
            force = hold_force(state.v, base.frequency_ratio**2 * sine, inertia)
            slip = 1.0 if force > 0.0 else -1.0
            return State(
                state.v, 0.0, slip, state.wall, state.gap, state.p_rate, state.riding, 1, 0, state.dwell
            )
    if particle is not None:
        if kind == RELEASE:
            return _release(state, sine, cosine, base, friction)
        if kind in (NEAR_WALL, FAR_WALL):
            wall = state.wall if kind == NEAR_WALL else -state.wall
            return _impact(
                state,
                wall,
                sine,
                cosine,
                base,
                friction,
                particle,
                particle.contact_time,
                counts,
                meter,
            )
        if kind == LET_GO:
            return _let_go(
                state, sine, cosine, base, friction, particle, particle.contact_time, counts, meter
            )
    return state


@kernel
def _release(state, sine, cosine, base, friction):
    """The wall stops pushing: the particle flies on with the velocity of the wall."""
    r = base.frequency_ratio
    held = False
    offset = 0.0
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
    opening = state.wall * r * r * sine if held else state.wall * (base.two_zeta * state.w + state.v + offset)
    # at a release found by its root the wall's acceleration is zero up to rounding, so the gap opens with its rate
    scale = r * r + abs(state.w) + abs(state.v) + abs(offset)
    order = 2 if opening > 1e-9 * scale else 3
    p_rate = state.w + r * cosine
    return State(state.v, state.w, state.slip, state.wall, 0.0, p_rate, 0.0, 0, order, state.dwell)


@kernel
def _come_to_rest(state, sine, cosine, base, friction, particle):
    """The mass has come to rest on the base: it sticks, or slips on or back, alone or with the particle on its wall.

    With the particle in contact the free alternative is tried first: where the wall would then run away from the particle
    it is released, otherwise it rides, and friction is judged with both masses. Exactly one of the two is consistent.
    A particle that dwells on its wall has no such choice.
    """
    acceleration = base.frequency_ratio**2 * sine
    r2 = base.frequency_ratio**2
    slip = slip_direction(hold_force(state.v, acceleration, 1.0), breakaway(friction, r2, 1.0))
    riding = 0.0
    gap_order = 0
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = base.frequency_ratio * cosine
            free_acceleration = -acceleration if slip == 0.0 else -(state.v + slip * friction)
            if state.wall * free_acceleration >= 0.0 or is_dwelling(state.dwell):
                riding = 1.0
                inertia = 1.0 + particle.mass_ratio
                force = hold_force(state.v, acceleration, inertia)
                slip = slip_direction(force, breakaway(friction, r2, inertia))
            else:
                gap_order = 2
    slip_order = 0 if slip == 0.0 else 1
    return State(
        state.v, 0.0, slip, state.wall, state.gap, p_rate, riding, slip_order, gap_order, state.dwell
    )


@kernel
def _impact(state, wall, sine, cosine, base, friction, particle, contact_time, counts, meter):
    """An impact on the given wall, and what follows at once: a flight, riding on the wall, or being held there."""
    u_rate = state.w + base.frequency_ratio * cosine
    approach = max(wall * (u_rate - state.p_rate), 0.0)
    counts[IMPACTS] += 1
    if meter is not None:
        meter[SPEED] = max(meter[SPEED], approach)
        meter[IMPACT_LOSS] += impact_loss(approach, particle.restitution, particle.mass_ratio)
    before = u_rate - wall * approach
    if contact_time is not None:
        jump, p_rate = rebound(u_rate, before, 0.0, particle.mass_ratio)
        dwell = Dwell(contact_time, approach)
        return _join(state, wall, state.w + jump, p_rate, sine, base, friction, particle, dwell)
    jump, p_rate = rebound(u_rate, before, particle.restitution, particle.mass_ratio)
    leaving = particle.restitution * approach
    return _leave(
        state,
        wall,
        state.w + jump,
        p_rate,
        leaving,
        u_rate,
        sine,
        cosine,
        base,
        friction,
        particle,
        contact_time,
        counts,
        meter,
    )


@kernel
def _let_go(state, sine, cosine, base, friction, particle, contact_time, counts, meter):
    """The contact time is over: the particle leaves with e times its approach speed, or rides on."""
    if contact_time is None:
        return state
    u_rate = state.w + base.frequency_ratio * cosine
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
            return _come_to_rest(riding, sine, cosine, base, friction, particle)
    return _leave(
        state,
        state.wall,
        state.w + jump,
        u_rate + p_jump,
        leaving,
        u_rate,
        sine,
        cosine,
        base,
        friction,
        particle,
        contact_time,
        counts,
        meter,
    )


@kernel
def _leave(
    state,
    wall,
    w,
    p_rate,
    leaving,
    u_rate_before,
    sine,
    cosine,
    base,
    friction,
    particle,
    contact_time,
    counts,
    meter,
):
    """The particle leaves a wall with a relative speed: a flight, or riding on the wall when the chatter is over."""
    base_rate = base.frequency_ratio * cosine
    slip = state.slip
    held = False
    offset = 0.0
    if friction is not None:
        if w != 0.0:
            slip = 1.0 if w > 0.0 else -1.0
        held = slip == 0.0
        offset = slip * friction
    acceleration = base.frequency_ratio**2 * sine
    u_acceleration = -acceleration if held else -(base.two_zeta * w + state.v + offset)
    closing = wall * u_acceleration  # rate at which the wall catches up with the particle
    rounding = _SPEED_ROUNDING * (abs(u_rate_before) + abs(p_rate) + abs(base_rate))
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
        jump, p_rate = rebound(w + base_rate, p_rate, 0.0, particle.mass_ratio)
        if meter is not None:
            meter[IMPACT_LOSS] += impact_loss(leaving, 0.0, particle.mass_ratio)
        return _join(state, wall, w + jump, p_rate, sine, base, friction, particle, dwell)
    return State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, 1 if leaving > 0.0 else 2, dwell)


@kernel
def _join(state, wall, w, p_rate, sine, base, friction, particle, dwell):
    """Particle and primary mass move on together at the velocity w relative to the base."""
    slip = state.slip
    if friction is not None:
        if w != 0.0:
            slip = 1.0 if w > 0.0 else -1.0
        else:
            inertia = 1.0 + particle.mass_ratio
            limit = breakaway(friction, base.frequency_ratio**2, inertia)
            force = hold_force(state.v, base.frequency_ratio**2 * sine, inertia)
            slip = slip_direction(force, limit)
            return State(state.v, 0.0, slip, wall, 0.0, p_rate, 1.0, 1 if slip != 0.0 else 0, 0, dwell)
    return State(state.v, w, slip, wall, 0.0, p_rate, 1.0, 0, 0, dwell)
