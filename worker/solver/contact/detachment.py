"""Detachment: a rigid wall stops pushing a particle in sustained contact, and the particle leaves the wall with zero
relative speed.
"""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.contact.rest import acceleration_alone
from damperlab.worker.solver.excitation.excitation import Phase, largest_forcing
from damperlab.worker.solver.regime import slip_regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State, in_flight

# fraction of the present accelerations below which the acceleration of the gap is a rounding error
_STILL = 1e-9


@inlined
def detach(state: State, phase: Phase, scene: Scene) -> State:
    """Return the state after the wall stops pushing: the particle flies on with the velocity of the wall."""
    _, offset = slip_regime(state.slip, scene.friction)
    opening = -state.wall * acceleration_alone(state.v, state.w, state.slip, phase, scene)
    # At a detachment found as a root, the relative acceleration is zero within rounding.
    # The time derivative of this acceleration then opens the gap.
    scale = largest_forcing(scene.base) + abs(state.w) + abs(state.v) + abs(offset)
    order = 2 if opening > _STILL * scale else 3
    return in_flight(
        state,
        w=state.w,
        slip=state.slip,
        wall=state.wall,
        p_rate=state.w + phase.rate,
        gap_order=order,
        dwell=state.dwell,
    )
