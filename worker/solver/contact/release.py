"""A wall that stops pushing."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.base import acceleration_scale
from damperlab.worker.solver.state import State


@inlined
def release(state, phase, base, friction):
    """The wall stops pushing: the particle flies on with the velocity of the wall."""
    held = False
    offset = 0.0
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
    opening = state.wall * phase.push if held else state.wall * (base.two_zeta * state.w + state.v + offset)
    # at a release found by its root the wall's acceleration is zero up to rounding, so the gap opens with its rate
    scale = acceleration_scale(base) + abs(state.w) + abs(state.v) + abs(offset)
    order = 2 if opening > 1e-9 * scale else 3
    p_rate = state.w + phase.rate
    return State(state.v, state.w, state.slip, state.wall, 0.0, p_rate, 0.0, 0, order, state.dwell)
