"""A long step over a decaying contact vibration: polynomials for the slow motion, an exponential for the vibration."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import CompliantRegime, buffers_of
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.events import NOTHING
from damperlab.worker.solver.excitation.excitation import Phase, base_velocity
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    Y_RATE,
    Y,
)
from damperlab.worker.solver.motion.taylor import change, slope, value
from damperlab.worker.solver.motion.vibration import (
    Vibration,
    form_of,
    form_of_w,
    form_of_x,
    value_of_form,
    vibration_after,
)
from damperlab.worker.solver.observe.measure_long_step import measure_long_step
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State, advanced


@kernel
def coordinates_into(state: State, regime: CompliantRegime, phase: Phase, start: Floats) -> None:
    """Write the six coordinates of a state in contact into `start`."""
    y = -state.wall * state.gap
    y_rate = state.wall * approach_speed(state.dwell)
    start[CENTRE] = (state.v + regime.offset) - regime.motion.share * y
    start[CENTRE_RATE] = 0.0 if regime.sticks else state.w - regime.motion.share * y_rate
    start[BASE_FIRST] = phase.first
    start[BASE_SECOND] = phase.second
    start[Y] = y
    start[Y_RATE] = y_rate


@kernel
def after_long_step(
    state: State,
    t: float,
    vibration: Vibration,
    regime: CompliantRegime,
    scene: Scene,
    meter: Meter | None,
) -> tuple[State, float, int]:
    """Return the state after a long step, the length of the step, and NOTHING, because the step has no event."""
    motion, buffers = regime.motion, buffers_of(scene)
    after = vibration_after(vibration, motion.rates, t)
    v = state.v
    w = 0.0
    if not regime.sticks:
        changed = Vibration(after.first - vibration.first, after.second - vibration.second)
        v = state.v + (change(buffers.relative, t) + value_of_form(changed, form_of_x(motion)))
        w = slope(buffers.relative, t) + value_of_form(after, form_of_w(motion))
    y = value(buffers.y, t) + value_of_form(after, form_of(Y, motion))
    y_rate = slope(buffers.y, t) + value_of_form(after, form_of(Y_RATE, motion))
    if meter is not None:
        measure_long_step(meter, state.v, v, t, vibration, after, regime, scene)
    p_rate = w + base_velocity(scene.base, buffers.excitation, t) - y_rate
    end = advanced(state, v, w, -state.wall * y, p_rate, Dwell(0.0, state.wall * y_rate), 0)
    return end, t, NOTHING
