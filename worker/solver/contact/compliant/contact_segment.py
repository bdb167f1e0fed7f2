"""Integration of compliant contact by Taylor polynomials, to the first event or to the end of a span."""

from math import inf

from damperlab.worker.jit import kernel
from damperlab.worker.physics.friction import breakaway
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import (
    AnyRegime,
    CompliantRegime,
    buffers_of,
    wall_of,
)
from damperlab.worker.solver.events import NOTHING, RELEASE, SLIP_ONSET, TURN
from damperlab.worker.solver.excitation.excitation import (
    Phase,
    add_start_of_base,
    expand_forcing,
    largest_forcing,
)
from damperlab.worker.solver.expansion import mass_at
from damperlab.worker.solver.motion.compliant_motion import (
    OF_ABSOLUTE,
    OF_RELATIVE,
    OF_WALL_FORCE,
    OF_Y,
    combine_rows,
)
from damperlab.worker.solver.motion.first_root import first_beyond, first_crossing
from damperlab.worker.solver.motion.taylor import (
    TERMS,
    curvature_bound,
    rate_into,
    slope,
    value,
)
from damperlab.worker.solver.observe.measure_contact import measure_contact
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State, advanced


@kernel
def expand(start: Floats, units: int, rows: Floats, phase: Phase, scene: Scene) -> None:
    """Compute the polynomials of x, x + s, y and the wall force from the first `units` coordinates.

    The polynomials are written into the buffers of the scene.
    """
    buffers = buffers_of(scene)
    combine_rows(OF_RELATIVE, start, units, rows, buffers.relative)
    combine_rows(OF_ABSOLUTE, start, units, rows, buffers.absolute)
    add_start_of_base(scene.base, phase, buffers.absolute)
    combine_rows(OF_Y, start, units, rows, buffers.y)
    combine_rows(OF_WALL_FORCE, start, units, rows, buffers.wall_force)


@kernel
def to_event(
    state: State, phase: Phase, span: float, regime: CompliantRegime, scene: Scene, meter: Meter | None
) -> tuple[State, float, int]:
    """Evaluate the expanded polynomials at the first event, or at the end of the span."""
    buffers = buffers_of(scene)
    relative, depth, scratch = buffers.relative, buffers.y, buffers.scratch
    t, kind = friction_event(state, phase, span, regime, scene)
    order = state.gap_order
    for i in range(TERMS - order):
        scratch[i] = buffers.wall_force[i + order]
    for i in range(TERMS - order, TERMS):
        scratch[i] = 0.0
    found = first_crossing(scratch, state.wall, 0.0, t, curvature_bound(scratch, t))
    if found < inf:
        t, kind = found, RELEASE
    v, w = mass_at(state, t, regime.sticks, relative)
    y = value(depth, t)
    y_rate = slope(depth, t)
    if meter is not None:
        measure_contact(meter, v - state.v, t, wall_of(scene).damping, regime, scene)
    order = order if t == 0.0 else 0  # at t = 0, this event coincides with the last
    p_rate = slope(buffers.absolute, t) - y_rate
    end = advanced(state, v, w, -state.wall * y, p_rate, Dwell(0.0, state.wall * y_rate), order)
    return end, t, kind


@kernel
def friction_event(
    state: State, phase: Phase, span: float, regime: AnyRegime, scene: Scene
) -> tuple[float, int]:
    """Find the time at which slip starts or stops under the wall force in `buffers.wall_force`."""
    t = span
    kind = NOTHING
    if scene.friction is not None:
        buffers = buffers_of(scene)
        scratch = buffers.scratch
        if regime.sticks:
            expand_forcing(scene.base, phase, -1.0, 1.0, scratch)
            for i in range(TERMS):
                scratch[i] += buffers.wall_force[i]
            limit = breakaway(scene.friction, largest_forcing(scene.base) + abs(buffers.wall_force[0]))
            found = first_beyond(scratch, state.v, limit, t, curvature_bound(scratch, t))
            if found < inf:
                t, kind = found, SLIP_ONSET
        else:
            rate_into(buffers.relative, state.slip_order, scratch)
            found = first_crossing(scratch, state.slip, 0.0, t, curvature_bound(scratch, t))
            if found < inf:
                t, kind = found, TURN
    return t, kind
