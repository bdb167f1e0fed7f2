"""A span in contact with a compliant wall, on expanded polynomials: to its first event, or to its end."""

from math import inf

from damperlab.worker.jit import kernel
from damperlab.worker.physics.friction import breakaway
from damperlab.worker.solver.contact.compliant.observables import measure_contact, raise_peaks
from damperlab.worker.solver.excitation.base import (
    acceleration_scale,
    push_into,
)
from damperlab.worker.solver.motion.contact import ABSOLUTE, DEPTH, PUSH, RELATIVE, combine_rows
from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import (
    TERMS,
    change,
    curvature_bound,
    rate_into,
    slope,
    value,
)
from damperlab.worker.solver.state import (
    NOTHING,
    RELEASE,
    SLIP_ONSET,
    STUCK,
    TURN,
    Dwell,
    State,
)


@kernel
def expand(start, units, rows, buffers):
    """Polynomials of x, x + s, y and the push into the buffers, from the first `units` coordinates."""
    combine_rows(RELATIVE, start, units, rows, buffers.relative)
    combine_rows(ABSOLUTE, start, units, rows, buffers.absolute)
    combine_rows(DEPTH, start, units, rows, buffers.depth)
    combine_rows(PUSH, start, units, rows, buffers.push)


@kernel
def to_event(state, wall, phase, span, offset, held, base, friction, buffers, meter):
    """To the first event on the expanded polynomials of contact, or to the end of the span."""
    relative, depth = buffers.relative, buffers.depth
    t, kind = friction_event(state, held, phase, span, base, friction, buffers)
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
def friction_event(state, held, phase, span, base, friction, buffers):
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
