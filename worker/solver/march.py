"""March through half an excitation cycle, from event to event.

What a scene lacks is None here, and the compiler drops it: without `friction` there is no search for turns and no stick,
without `particle` no gap, no impact, no riding; without `meter` no energies and no peaks; without `log` no history.
"""

from math import inf

from worker.jit import kernel
from worker.physics.friction import hold_force, slip_direction
from worker.physics.impact import impact_loss, rebound
from worker.solver.bounds import derivative_bounds, motion_bounds
from worker.solver.crossing import first_crossing
from worker.solver.measure import measure
from worker.solver.record import record
from worker.solver.scene import (
    ARRIVED,
    ATTACHMENTS,
    BUDGET,
    IDLE,
    IMPACT_LOSS,
    IMPACTS,
    OUT_OF_EVENTS,
    SEGMENTS,
    SPEED,
    STALLED,
    TURNS,
    State,
)
from worker.solver.taylor import (
    ORDER,
    derivative_into,
    expand_base,
    expand_slip,
    expand_stick,
    slope,
    value,
)

_NOTHING, _TURN, _SLIP, _NEAR_WALL, _FAR_WALL, _RELEASE = 0, 1, 2, 3, 4, 5

# A chatter is cut short when what is left of it takes less than this share of a window. Joining the bodies then conserves
# momentum, so the error is (time left)² × acceleration: below 1e-17 of the motion, less than rounding.
_CHATTER_LEFT = 1e-8
_SPEED_ROUNDING = 1e-14  # relative: below this an outgoing speed is rounding
_MOST_IDLE = 64  # events without time moving on before the march gives up


@kernel
def half_cycle(state, base, free, loaded, friction, particle, work, counts, meter, log):
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
    work : array, shape (4, ORDER + 1)
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
    shaken = work[0]
    relative = work[1]
    absolute = work[2]
    scratch = work[3]
    r = base.frequency_ratio
    for k in range(base.windows):
        sine = base.sine[k]
        cosine = base.cosine[k]
        left = base.window
        whole = True
        while True:
            medium = free
            if particle is not None:
                if state.riding > 0.0:
                    medium = loaded
            kind = _NOTHING
            quiet = _is_quiet(state, sine, cosine, left, base, medium, friction, particle)
            if meter is None and log is None:
                if quiet and whole:
                    state = _glide(state, base, medium, k, friction, particle)
                    break
            expand_base(sine, cosine, r, shaken)
            held = False
            if friction is not None:
                held = state.slip == 0.0
            if held:
                expand_stick(state.v, shaken, relative, absolute)
            else:
                offset = 0.0
                if friction is not None:
                    offset = state.slip * friction
                expand_slip(
                    state.v + offset, state.w, base.two_zeta, medium.compliance, shaken, relative, absolute
                )
            t = left
            if not quiet:
                t, kind = _next_event(
                    state, left, base, medium, friction, particle, shaken, relative, absolute, scratch
                )
            if meter is not None:
                measure(meter, state, t, base, medium, friction, shaken, relative, absolute, scratch)
            if log is not None:
                record(log, state, (k + 1) * base.window - left, t, kind)
            state = _coast(state, t, friction, particle, relative, absolute)
            if kind == _NOTHING:
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
        ),
        ARRIVED,
    )


@kernel
def _gap_rate(state, cosine, frequency_ratio):
    """Rate at which the particle leaves the wall last touched."""
    return state.wall * (state.p_rate - (state.w + frequency_ratio * cosine))


@kernel
def _is_quiet(state, sine, cosine, span, base, medium, friction, particle):
    """Whether bounds alone prove that no event lies in the span; False means that one must look."""
    r = base.frequency_ratio
    r2 = r * r
    held = False
    x = state.v
    if friction is not None:
        held = state.slip == 0.0
        x = state.v + state.slip * friction
    if held:
        acceleration_most = r2
        w_most = 0.0
    else:
        _x_most, w_most, acceleration_most = motion_bounds(
            x, state.w, span, base.two_zeta, medium.compliance, r
        )
    if friction is not None:
        if held:
            inertia = 1.0 / medium.compliance
            force = hold_force(state.v, r2 * sine, inertia)
            if abs(force) + inertia * r2 * r * span >= friction:
                return False
        elif state.slip_order > 0 or abs(state.w) <= span * (acceleration_most + r2):
            return False
    if particle is not None:
        if state.riding > 0.0:
            jerk_most = r2 * r
            acceleration = -r2 * sine
            if not held:
                jerk_most = medium.compliance * (base.two_zeta * (acceleration_most + r2) + w_most)
                acceleration = -medium.compliance * (base.two_zeta * state.w + x)
            if state.wall * acceleration <= span * jerk_most:
                return False
        else:
            drift = _gap_rate(state, cosine, r) * span
            bend = 0.5 * acceleration_most * span * span
            if state.gap_order > 0 or state.gap + min(0.0, drift) - bend <= 0.0:
                return False
            if state.gap + max(0.0, drift) + bend >= 2.0 * particle.clearance_ratio:
                return False
    return True


@kernel
def _glide(state, base, medium, k, friction, particle):
    """Cross window k, in which nothing happens, by its matrix."""
    offset = 0.0
    if friction is not None:
        offset = state.slip * friction
    v = state.v
    w = 0.0
    held = False
    if friction is not None:
        held = state.slip == 0.0
    if not held:
        x = state.v + offset
        v = medium.xx * x + medium.xw * state.w + medium.forced_x[k] - offset
        w = medium.wx * x + medium.ww * state.w + medium.forced_w[k]
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = w + base.frequency_ratio * base.cosine[k + 1]
        else:
            moved = (v - state.v) + (base.sine[k + 1] - base.sine[k])
            gap = state.gap + state.wall * (state.p_rate * base.window - moved)
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0)


@kernel
def _coast(state, t, friction, particle, relative, absolute):
    """State a time t later on the expanded polynomials."""
    v = state.v
    w = 0.0
    held = False
    offset = 0.0
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
    if not held:
        v = value(relative, t) - offset
        w = slope(relative, t)
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = slope(absolute, t)
        else:
            # Horner from the second power: the gap's own change, no difference of large displacements
            bend = absolute[ORDER]
            for i in range(ORDER - 1, 1, -1):
                bend = bend * t + absolute[i]
            rate = state.p_rate - absolute[1]
            gap = state.gap + state.wall * t * (rate - bend * t)
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0)


@kernel
def _next_event(state, span, base, medium, friction, particle, shaken, relative, absolute, scratch):
    """Time and kind of the first event within the span, (span, _NOTHING) where there is none."""
    r = base.frequency_ratio
    r2 = r * r
    held = False
    if friction is not None:
        held = state.slip == 0.0
    inertia = 1.0 / medium.compliance
    if held:
        u2, u3, u4, u5 = r2, r2 * r, r2 * r2, r2 * r2 * r
        w2, w3, w4 = 0.0, 0.0, 0.0
    else:
        x_most, w_most, u2 = motion_bounds(relative[0], state.w, span, base.two_zeta, medium.compliance, r)
        u3, u4, u5, w2, w3, w4 = derivative_bounds(x_most, w_most, u2, base.two_zeta, medium.compliance, r)
    t = span
    kind = _NOTHING
    if friction is not None:
        if held:
            for i in range(ORDER + 1):
                scratch[i] = -inertia * r2 * shaken[i]
            force_bend = inertia * r2 * r2
            scratch[0] += state.v + friction
            found = first_crossing(scratch, 0, 1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, _SLIP
            scratch[0] -= 2.0 * friction
            found = first_crossing(scratch, 0, -1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, _SLIP
        else:
            derivative_into(relative, 1, scratch)
            order = state.slip_order
            bend = w2
            if order == 1:
                bend = w3 / 3.0
            elif order == 2:
                bend = w4 / 12.0
            found = first_crossing(scratch, order, state.slip, 0.0, t, bend)
            if found < inf:
                t, kind = found, _TURN
    if particle is not None:
        if state.riding > 0.0:
            derivative_into(absolute, 2, scratch)
            found = first_crossing(scratch, 0, state.wall, 0.0, t, u4)
            if found < inf:
                t, kind = found, _RELEASE
        else:
            for i in range(2, ORDER + 1):
                scratch[i] = -state.wall * absolute[i]
            scratch[1] = state.wall * (state.p_rate - absolute[1])
            scratch[0] = state.gap
            order = state.gap_order
            bend = u2
            if order == 1:
                bend = u3 / 3.0
            elif order == 2:
                bend = u4 / 12.0
            elif order == 3:
                bend = u5 / 60.0
            found = first_crossing(scratch, order, 1.0, 0.0, t, bend)
            if found < inf:
                t, kind = found, _NEAR_WALL
            scratch[0] = state.gap - 2.0 * particle.clearance_ratio
            found = first_crossing(scratch, 0, -1.0, 0.0, t, u2)
            if found < inf:
                t, kind = found, _FAR_WALL
    return t, kind


@kernel
def _pass_event(state, kind, sine, cosine, base, friction, particle, counts, meter):
    """What the event changes: one transition, after which slip, contact and their orders are consistent again."""
    if friction is not None:
        if kind == _TURN:
            counts[TURNS] += 1
            return _come_to_rest(state, sine, cosine, base, friction, particle)
        if kind == _SLIP:
            inertia = 1.0
            if particle is not None:
                if state.riding > 0.0:
                    inertia = 1.0 + particle.mass_ratio
            force = hold_force(state.v, base.frequency_ratio**2 * sine, inertia)
            slip = 1.0 if force > 0.0 else -1.0
            return State(state.v, 0.0, slip, state.wall, state.gap, state.p_rate, state.riding, 2, 0)
    if particle is not None:
        if kind == _RELEASE:
            return _release(state, sine, cosine, base, friction)
        if kind in (_NEAR_WALL, _FAR_WALL):
            wall = state.wall if kind == _NEAR_WALL else -state.wall
            return _impact(state, wall, sine, cosine, base, friction, particle, counts, meter)
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
    return State(state.v, state.w, state.slip, state.wall, 0.0, state.w + r * cosine, 0.0, 0, order)


@kernel
def _come_to_rest(state, sine, cosine, base, friction, particle):
    """The mass has come to rest on the base: it sticks, or slips on or back, alone or with the particle on its wall.

    With the particle in contact the free alternative is tried first: where the wall would then run away from the particle
    it is released, otherwise it rides, and friction is judged with both masses. Exactly one of the two is consistent.
    """
    acceleration = base.frequency_ratio**2 * sine
    slip = slip_direction(hold_force(state.v, acceleration, 1.0), friction)
    riding = 0.0
    gap_order = 0
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = base.frequency_ratio * cosine
            free_acceleration = -acceleration if slip == 0.0 else -(state.v + slip * friction)
            if state.wall * free_acceleration >= 0.0:
                riding = 1.0
                slip = slip_direction(hold_force(state.v, acceleration, 1.0 + particle.mass_ratio), friction)
            else:
                gap_order = 2
    slip_order = 0 if slip == 0.0 else 1
    return State(state.v, 0.0, slip, state.wall, state.gap, p_rate, riding, slip_order, gap_order)


@kernel
def _impact(state, wall, sine, cosine, base, friction, particle, counts, meter):
    """An impact on the given wall, and what follows: a flight, or riding on the wall when the chatter is over."""
    base_rate = base.frequency_ratio * cosine
    u_rate = state.w + base_rate
    approach = max(wall * (u_rate - state.p_rate), 0.0)
    counts[IMPACTS] += 1
    jump, p_rate = rebound(u_rate, u_rate - wall * approach, particle.restitution, particle.mass_ratio)
    w = state.w + jump
    if meter is not None:
        meter[SPEED] = max(meter[SPEED], approach)
        meter[IMPACT_LOSS] += impact_loss(approach, particle.restitution, particle.mass_ratio)
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
    leaving = particle.restitution * approach
    closing = wall * u_acceleration  # rate at which the wall catches up with the particle
    rounding = _SPEED_ROUNDING * (abs(u_rate) + abs(p_rate) + abs(base_rate))
    time_left = 2.0 * leaving / (1.0 - particle.restitution) if particle.restitution < 1.0 else inf
    if leaving == 0.0 and closing == 0.0:
        # a tie: the sign of the change of the wall's acceleration decides, which the search for a release looks at
        closing = rounding
        leaving = 0.0
    if closing > 0.0 and (time_left <= _CHATTER_LEFT * base.window * closing or leaving <= rounding):
        counts[ATTACHMENTS] += 1
        u_rate = w + base_rate
        jump, p_rate = rebound(u_rate, p_rate, 0.0, particle.mass_ratio)
        if meter is not None:
            meter[IMPACT_LOSS] += impact_loss(leaving, 0.0, particle.mass_ratio)
        w = w + jump
        if friction is not None:
            if w != 0.0:
                slip = 1.0 if w > 0.0 else -1.0
            else:
                slip = slip_direction(hold_force(state.v, acceleration, 1.0 + particle.mass_ratio), friction)
                return State(state.v, 0.0, slip, wall, 0.0, p_rate, 1.0, 1 if slip != 0.0 else 0, 0)
        return State(state.v, w, slip, wall, 0.0, p_rate, 1.0, 0, 0)
    return State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, 1 if leaving > 0.0 else 2)
