"""Flight of a particle that has detached from a compliant wall but still penetrates the wall. The flight ends when the
particle is clear of the wall or is pushed again.
"""

from math import inf

from damperlab.worker.jit import kernel
from damperlab.worker.physics.compliant_wall import spring_energy
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import buffers_of, wall_of
from damperlab.worker.solver.contact.compliant.contact_segment import friction_event
from damperlab.worker.solver.events import CLEARANCE, PUSHED_AGAIN
from damperlab.worker.solver.excitation.excitation import (
    Phase,
    expand_excitation,
)
from damperlab.worker.solver.expansion import expand_motion, mass_at
from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import (
    TERMS,
    curvature_bound,
    value,
)
from damperlab.worker.solver.observe.measure_contact import measure_contact
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, Meter
from damperlab.worker.solver.regime import regime_of
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State, advanced

_NEAR = 1e-6  # Fraction of a span that is searched first for a root.
_WIDER = 16.0  # Factor by which the searched fraction grows.


@kernel
def separate(
    state: State, phase: Phase, time_left: float, scene: Scene, meter: Meter | None
) -> tuple[State, float, int]:
    """Integrate one segment of a particle that has detached but still penetrates the wall; no wall force acts."""
    base, wall, buffers = scene.base, wall_of(scene), buffers_of(scene)
    relative, absolute, scratch = buffers.relative, buffers.absolute, buffers.scratch
    pen = buffers.y  # wall · y, the penetration of the particle
    regime = regime_of(state, scene)
    expand_excitation(base, phase, buffers.excitation)
    expand_motion(state, phase, regime, scene, meter, relative, absolute)
    for i in range(TERMS):
        buffers.wall_force[i] = 0.0
        pen[i] = state.wall * absolute[i]
    pen[0] = -state.gap
    pen[1] = state.wall * (absolute[1] - state.p_rate)
    t, kind = friction_event(state, phase, time_left, regime, scene)
    near = 2.0 * pen[0] / -pen[1] if pen[1] < 0.0 else _NEAR * t
    found = _crossing_from(pen, near, t)
    if found < inf:
        t, kind = found, CLEARANCE
    # spring and dashpot push again where K pen + C pen' rises through zero; this sum may be 0 just after the detachment
    order = state.gap_order
    lead = wall.damping / wall.stiffness
    for i in range(TERMS - order):
        n = i + order
        scratch[i] = -pen[n]
        if n + 1 < TERMS:
            scratch[i] -= lead * (n + 1) * pen[n + 1]
    for i in range(TERMS - order, TERMS):
        scratch[i] = 0.0
    found = _crossing_from(scratch, near, t)
    if found < inf:
        t, kind = found, PUSHED_AGAIN
    v, w = mass_at(state, t, regime.sticks, relative)
    pen_end = 0.0 if kind == CLEARANCE else value(pen, t)
    if meter is not None:
        measure_contact(meter, v - state.v, t, 0.0, regime, scene)
        if meter.energies is not None:
            lost = spring_energy(wall.stiffness, -state.gap) - spring_energy(wall.stiffness, pen_end)
            meter.sums[IMPACT_LOSS] += lost
    end = advanced(state, v, w, -pen_end, state.p_rate, Dwell(0.0, 0.0), 0)
    return end, t, kind


@kernel
def _crossing_from(polynomial: Floats, near: float, span: float) -> float:
    """First time at which a polynomial falls through zero, searched in intervals that grow from `near`.

    The root lies near the beginning of the span, because the particle penetrates a stiff wall only slightly. With a
    bound on the curvature over the complete span, the search would miss this root.
    """
    start = 0.0
    end = min(max(near, 1e-15 * span), span)
    while True:
        found = first_crossing(polynomial, 1.0, start, end, curvature_bound(polynomial, end))
        if found < inf or end >= span:
            return found
        start = end
        end = min(_WIDER * end, span)
