"""The first event of a span: velocity zero, end of rest, a wall, contact force zero, end of a dwell."""

from math import inf

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway
from damperlab.worker.solver.detection.bounds import u_bend, w_bend
from damperlab.worker.solver.dwell import is_dwelling, time_left
from damperlab.worker.solver.excitation.base import acceleration_scale, base_bend, push_into
from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import TERMS, acceleration_into, rate_into
from damperlab.worker.solver.state import FAR_WALL, LET_GO, NEAR_WALL, NOTHING, RELEASE, SLIP_ONSET, TURN

# Bound on the second derivative of p(t)/t^k over that on the (k + 2)th of p: 2/(k + 2)!.
_DROPPED = (1.0, 1.0 / 3.0, 1.0 / 12.0, 1.0 / 60.0)


@inlined
def next_event(
    state,
    held,
    phase,
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
    inertia = 1.0 / medium.compliance
    t = span
    kind = NOTHING
    if friction is not None:
        if held:
            push_into(base, phase, -inertia, scratch)
            force_bend = inertia * base_bend(base, phase, 4)
            limit = breakaway(friction, acceleration_scale(base), inertia)
            scratch[0] += state.v + limit
            found = first_crossing(scratch, 1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, SLIP_ONSET
            scratch[0] -= 2.0 * limit
            found = first_crossing(scratch, -1.0, 0.0, t, force_bend)
            if found < inf:
                t, kind = found, SLIP_ONSET
        elif state.slip_order > 0 or abs(state.w) <= span * (u2_most + base_bend(base, phase, 2)):
            order = state.slip_order
            rate_into(relative, order, scratch)
            most = w_bend(order, w_most, u2_most, base, phase, medium.compliance)
            found = first_crossing(scratch, state.slip, 0.0, t, most)
            if found < inf:
                t, kind = found, TURN
    if particle is not None:
        if is_dwelling(dwell):
            if time_left(dwell) <= t:
                t, kind = time_left(dwell), LET_GO
        elif state.riding > 0.0:
            acceleration_into(absolute, scratch)
            most = u_bend(4, held, w_most, u2_most, base, phase, medium.compliance)
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
                    u_bend(2 + order, held, w_most, u2_most, base, phase, medium.compliance)
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
