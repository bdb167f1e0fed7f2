"""Proofs that nothing happens in a span: no function whose zeros are events can have one there."""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import hold_force
from damperlab.worker.solver.detection.bounds import motion_bounds, u_bend, w_bend
from damperlab.worker.solver.dwell import is_dwelling, time_left
from damperlab.worker.solver.excitation.base import base_bend


@inlined
def gap_rate(state, phase):
    """Rate at which the particle leaves the wall last touched."""
    return state.wall * (state.p_rate - (state.w + phase.rate))


@inlined
def most_motion(state, offset, held, span, base, phase, medium):
    """Bounds on |x|, |w| and |u''| over the span."""
    if held:
        return abs(state.v), 0.0, base_bend(base, phase, 2)
    return motion_bounds(state.v + offset, state.w, span, base, phase, medium.compliance)


@inlined
def was_quiet(
    start, end, offset, held, phase, push_end, base, medium, friction, particle, dwell, w_most, u2_most
):
    """Whether a window crossed by its matrix held no event: none of the functions whose zeros are events can have one.

    Between its ends a function is at least the smaller of the two less span²/8 times its curvature.
    """
    share = 0.125 * base.window * base.window
    if start.slip_order + start.gap_order > 0:
        return False
    if friction is not None:
        if held:
            inertia = 1.0 / medium.compliance
            force = abs(hold_force(start.v, phase.push, inertia))
            force_end = abs(hold_force(start.v, push_end, inertia))
            if max(force, force_end) + share * inertia * base_bend(base, phase, 4) >= friction:
                return False
        else:
            most = share * w_bend(0, w_most, u2_most, base, phase, medium.compliance)
            if min(start.slip * start.w, start.slip * end.w) <= most:
                return False
    if particle is not None:
        if is_dwelling(dwell):
            return time_left(dwell) > base.window
        if start.riding > 0.0:
            most = share * u_bend(4, held, w_most, u2_most, base, phase, medium.compliance)
            acceleration = -phase.push
            acceleration_end = -push_end
            if not held:
                acceleration = -medium.compliance * (base.two_zeta * start.w + start.v + offset)
                acceleration_end = -medium.compliance * (base.two_zeta * end.w + end.v + offset)
            if min(start.wall * acceleration, start.wall * acceleration_end) <= most:
                return False
        else:
            most = share * u2_most
            if min(start.gap, end.gap) <= most:
                return False
            if max(start.gap, end.gap) + most >= 2.0 * particle.clearance_ratio:
                return False
    return True


@inlined
def is_quiet(state, offset, held, phase, span, base, medium, friction, particle, dwell, w_most, u2_most):
    """Whether bounds alone prove that no event lies in the span; False means that one must look."""
    if friction is not None:
        if held:
            inertia = 1.0 / medium.compliance
            if (
                abs(hold_force(state.v, phase.push, inertia)) + inertia * base_bend(base, phase, 3) * span
                >= friction
            ):
                return False
        elif state.slip_order > 0 or abs(state.w) <= span * (u2_most + base_bend(base, phase, 2)):
            return False
    if particle is not None:
        if is_dwelling(dwell):
            return time_left(dwell) > span
        if state.riding > 0.0:
            jerk_most = base_bend(base, phase, 3)
            acceleration = -phase.push
            if not held:
                jerk_most = medium.compliance * (
                    base.two_zeta * (u2_most + base_bend(base, phase, 2)) + w_most
                )
                acceleration = -medium.compliance * (base.two_zeta * state.w + state.v + offset)
            if state.wall * acceleration <= span * jerk_most:
                return False
        else:
            drift = gap_rate(state, phase) * span
            sag = 0.5 * u2_most * span * span
            if state.gap_order > 0 or state.gap + min(0.0, drift) - sag <= 0.0:
                return False
            if state.gap + max(0.0, drift) + sag >= 2.0 * particle.clearance_ratio:
                return False
    return True
