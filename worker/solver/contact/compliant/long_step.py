"""A long step over a decaying contact vibration: polynomials for the slow motion, an exponential for the vibration.

The length of the step is limited so that the step provably contains no event. The proof uses the slow motion
and an envelope of the decaying vibration.
"""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.compliant_regime import CompliantRegime, buffers_of, wall_of
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.events import NOTHING
from damperlab.worker.solver.excitation.excitation import Phase, base_velocity, expand_forcing
from damperlab.worker.solver.excitation.record_base import RecordBase
from damperlab.worker.solver.motion.compliant_motion import write_coordinates
from damperlab.worker.solver.motion.slow_subspace import Y_RATE, Y
from damperlab.worker.solver.motion.taylor import TERMS, change, curvature_bound, rate_into, slope, value
from damperlab.worker.solver.motion.vibration import (
    ENVELOPE_SAFETY,
    Vibration,
    form_of,
    form_of_w,
    form_of_wall_force,
    form_of_x,
    gain_of,
    size_of,
    value_of_form,
    vibration_after,
)
from damperlab.worker.solver.observe.measure_long_step import LEAST_DECAY, measure_long_step
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import Dwell, State, advanced

# Least length of a long step, in ordinary steps. For a shorter step, the proof would cost more than the step saves.
FEWEST_STEPS = 8.0
_SHORTER = 0.125


@kernel
def _lower_bound(polynomial: Floats, sign: float, t: float) -> float:
    """Lower bound of sign · p over [0, t]: the smaller end value, minus t²/8 times a bound on |p''|."""
    ends = min(sign * polynomial[0], sign * value(polynomial, t))
    return ends - 0.125 * t * t * curvature_bound(polynomial, t)


@kernel
def longest_step(
    state: State,
    phase: Phase,
    span: float,
    vibration: Vibration,
    regime: CompliantRegime,
    scene: Scene,
    meter: Meter | None,
) -> float:
    """Longest span in which slow motion and vibration provably cause no event; 0 if the span would be too short.

    If a meter is given, the span is also limited so that no displacement exceeds its previous peak. Under a
    record, u'' of a slipping mass must not exceed its previous peak either. The buffers must contain the slow
    motion (`contact_segment.expand`).
    """
    base, friction, offset, motion = scene.base, scene.friction, regime.offset, regime.motion
    wall, buffers = wall_of(scene), buffers_of(scene)
    size = ENVELOPE_SAFETY * size_of(vibration, motion.weight)
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
        clear = _lower_bound(buffers.wall_force, state.wall, t) > wall_force_most
        if friction is not None:
            if regime.sticks:
                force = max(-_lower_bound(scratch, 1.0, t), -_lower_bound(scratch, -1.0, t))
                clear = clear and force < limit
            else:
                clear = clear and _lower_bound(scratch, state.slip, t) > w_most
        if meter is not None and clear:
            # This limit applies even if energies are not measured, so that measuring energies changes no bit.
            clear = abs(motion.rates[0] + motion.rates[3]) * t >= LEAST_DECAY
            if isinstance(base, RecordBase):
                if not regime.sticks:
                    most = curvature_bound(buffers.absolute, t) + (
                        base.two_zeta * w_most + x_most + wall_force_most
                    )
                    clear = clear and most <= meter.sums[ACCELERATION_PEAK]
            sign = 1.0 if rate[0] > 0.0 else -1.0
            if _lower_bound(rate, sign, t) <= w_most:
                u_most = max(abs(buffers.absolute[0] - offset), abs(value(buffers.absolute, t) - offset))
                u_most += 0.125 * t * t * curvature_bound(buffers.absolute, t) + x_most
                clear = clear and u_most <= meter.sums[PEAK]
            if friction is None and clear:
                rate_into(buffers.relative, 0, scratch)
                sign = 1.0 if scratch[0] > 0.0 else -1.0
                if _lower_bound(scratch, sign, t) <= w_most:
                    v_most = max(abs(buffers.relative[0]), abs(value(buffers.relative, t)))
                    v_most += 0.125 * t * t * curvature_bound(buffers.relative, t) + x_most
                    clear = v_most <= meter.sums[RELATIVE_PEAK]
        if clear:
            return t
        t *= _SHORTER
    return 0.0


@kernel
def coordinates_into(state: State, regime: CompliantRegime, phase: Phase, start: Floats) -> None:
    """Write the six coordinates of a state in contact into `start`."""
    y, y_rate = -state.wall * state.gap, state.wall * approach_speed(state.dwell)
    x, w = state.v + regime.offset, 0.0 if regime.sticks else state.w
    write_coordinates(x, w, phase.first, phase.second, y, y_rate, regime.motion.share, start)


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
