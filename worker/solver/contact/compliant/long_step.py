"""A long step over the decaying vibration of a contact: as far as its envelope proves that it causes no event."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.contact_regime import (
    ContactRegime,
    buffers_of,
    wall_of,
)
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.events import NOTHING
from damperlab.worker.solver.excitation.excitation import Phase, expand_forcing
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.memory import Floats
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    DEPTH,
    DEPTH_RATE,
)
from damperlab.worker.solver.motion.taylor import (
    TERMS,
    change,
    curvature_bound,
    rate_into,
    slope,
    value,
)
from damperlab.worker.solver.motion.vibration import (
    Vibration,
    form_of,
    form_of_w,
    form_of_wall_force,
    form_of_x,
    gain_of,
    share_of,
    size_of,
    vibration_after,
)
from damperlab.worker.solver.observe.measure_acceleration_in_wall import raise_over_long_step
from damperlab.worker.solver.observe.measure_in_wall import TAME, measure_contact, measure_vibration
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, PEAK, RELATIVE_PEAK, STUCK, Meter
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State, advanced

FEWEST_STEPS = 8.0  # a long step of fewer than this many steps is not worth its proof
_SHORTER = 0.125
_SAFETY = 2.0  # the envelope of f falls exactly only without the coupling to the slow motion


@kernel
def coordinates_into(state: State, regime: ContactRegime, phase: Phase, start: Floats) -> None:
    """The six coordinates of a state in contact."""
    y = -state.wall * state.gap
    y_rate = state.wall * approach_speed(state.dwell)
    start[CENTRE] = (state.v + regime.offset) - regime.motion.share * y
    start[CENTRE_RATE] = 0.0 if regime.sticks else state.w - regime.motion.share * y_rate
    start[BASE_FIRST] = phase.first
    start[BASE_SECOND] = phase.second
    start[DEPTH] = y
    start[DEPTH_RATE] = y_rate


@kernel
def _least(polynomial: Floats, sign: float, t: float) -> float:
    """Lower bound of sign · p over [0, t]: between its ends a function sags by at most t²/8 of its curvature."""
    ends = min(sign * polynomial[0], sign * value(polynomial, t))
    return ends - 0.125 * t * t * curvature_bound(polynomial, t)


@kernel
def longest_step(
    state: State,
    phase: Phase,
    span: float,
    vibration: Vibration,
    regime: ContactRegime,
    scene: Scene,
    meter: Meter | None,
) -> float:
    """How far the vibration can be proved to cause no event, 0 where that is not worth it; the slow motion is expanded."""
    base, friction, offset, motion = scene.base, scene.friction, regime.offset, regime.motion
    wall, buffers = wall_of(scene), buffers_of(scene)
    size = _SAFETY * size_of(vibration, motion.weight)
    wall_force_most = size * gain_of(form_of_wall_force(motion, wall), motion.weight)
    if state.wall * buffers.wall_force[0] <= wall_force_most:
        return 0.0
    x_most = size * gain_of(form_of_x(motion), motion.weight)
    w_most = size * gain_of(form_of_w(motion), motion.weight)
    scratch, rate = buffers.scratch, buffers.rate
    limit = 0.0
    if friction is not None:
        if regime.sticks:
            expand_forcing(base, phase, 1.0, 1.0, scratch)
            for i in range(TERMS):
                scratch[i] -= buffers.wall_force[i]
            scratch[0] -= state.v
            limit = friction - wall_force_most
        else:
            rate_into(buffers.relative, 0, scratch)
    if meter is not None:
        rate_into(buffers.absolute, 0, rate)
    t = span
    while t > FEWEST_STEPS * motion.step:
        clear = _least(buffers.wall_force, state.wall, t) > wall_force_most
        if friction is not None:
            if regime.sticks:
                force = max(-_least(scratch, 1.0, t), -_least(scratch, -1.0, t))
                clear = clear and force < limit
            else:
                clear = clear and _least(scratch, state.slip, t) > w_most
        if meter is not None and clear:
            # whether energies are asked for or not, so that a point has the same bits
            clear = abs(motion.rates[0] + motion.rates[3]) * t >= TAME
            if isinstance(base, RecordBase):
                if not regime.sticks:
                    most = curvature_bound(buffers.absolute, t) + (
                        base.two_zeta * w_most + x_most + wall_force_most
                    )
                    clear = clear and most <= meter.sums[ACCELERATION_PEAK]
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
def after_long_step(
    state: State,
    t: float,
    vibration: Vibration,
    regime: ContactRegime,
    scene: Scene,
    meter: Meter | None,
) -> tuple[State, float, int]:
    """The state after a long step, its length, and that it ends without an event."""
    motion = regime.motion
    wall, buffers = wall_of(scene), buffers_of(scene)
    after = vibration_after(vibration, motion.rates, t)
    v = state.v
    w = 0.0
    if not regime.sticks:
        changed = Vibration(after.first - vibration.first, after.second - vibration.second)
        v = state.v + (change(buffers.relative, t) + share_of(changed, form_of_x(motion)))
        w = slope(buffers.relative, t) + share_of(after, form_of_w(motion))
    y = value(buffers.depth, t) + share_of(after, form_of(DEPTH, motion))
    y_rate = slope(buffers.depth, t) + share_of(after, form_of(DEPTH_RATE, motion))
    u_rate = w + slope(buffers.excitation, t)
    if meter is not None:
        sums = meter.sums
        if meter.energies is not None:
            measure_contact(meter, v - state.v, t, wall.damping, regime, scene)
            measure_vibration(meter, t, vibration, after, regime, scene)
        elif regime.sticks:
            sums[STUCK] += t
        sums[PEAK] = max(
            sums[PEAK], max(abs(state.v + buffers.excitation[0]), abs(v + value(buffers.excitation, t)))
        )
        sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], max(abs(state.v), abs(v)))
        if meter.acceleration is not None and not isinstance(scene.base, RecordBase):
            raise_over_long_step(meter, t, vibration, regime, scene)
    p_rate = u_rate - y_rate
    end = advanced(state, v, w, -state.wall * y, p_rate, Dwell(0.0, state.wall * y_rate), 0)
    return end, t, NOTHING
