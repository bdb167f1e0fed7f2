"""Bounds on the motion over a span, computed only from the state at its start."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.excitation import (
    Excitation,
    base_derivative_bound,
    with_force_bound,
)
from damperlab.worker.solver.regime import MotionBounds, Regime, Segment, Span
from damperlab.worker.solver.state import State


@inlined
def motion_bounds(state: State, regime: Regime, span: Span, base: Excitation) -> MotionBounds:
    """Bounds on |w| and |u''| over the rest of a panel.

    Notes
    -----
    Let W and X be bounds on |w| and |x| over a span of slip of length T, where x is the displacement from the
    shifted spring centre. Then W = |w₀| + T (κ(2ζ W + X) + max |s''|) and X = |x₀| + T W. These equations are
    solved for W. Under a force on the structure, X in the first equation is increased by the largest force. T
    is at most a panel (`taylor.LARGEST_WINDOW`), so the denominator of W stays above 0.5.
    """
    base_most = base_derivative_bound(base, span.phase, 2)
    if regime.sticks:
        return MotionBounds(0.0, base_most)
    two_zeta, compliance, time = base.two_zeta, regime.motion.compliance, span.remaining
    pulled = with_force_bound(abs(state.v + regime.offset), base, 0)
    w_most = (abs(state.w) + time * (compliance * pulled + base_most)) / (
        1.0 - compliance * time * (two_zeta + time)
    )
    pulled_most = pulled + time * w_most
    return MotionBounds(w_most, compliance * (two_zeta * w_most + pulled_most))


@inlined
def u_derivative_bound(order: int, segment: Segment, base: Excitation) -> float:
    """Bound on the `order`-th derivative of u over a segment, for `order` 2 to 5.

    The bound follows from derivatives of the equation of motion.
    """
    if segment.regime.sticks:
        return base_derivative_bound(base, segment.phase, order)
    return _in_slip(order, segment, base)


@inlined
def _in_slip(order: int, segment: Segment, base: Excitation) -> float:
    two_zeta = base.two_zeta
    compliance = segment.regime.motion.compliance
    if order == 2:
        return segment.bounds.u2
    w1 = w_rate_bound(segment, base)
    u3 = compliance * (two_zeta * w1 + with_force_bound(segment.bounds.w, base, 1))
    if order == 3:
        return u3
    w2 = u3 + base_derivative_bound(base, segment.phase, 3)
    u4 = compliance * (two_zeta * w2 + with_force_bound(w1, base, 2))
    if order == 4:
        return u4
    w3 = u4 + base_derivative_bound(base, segment.phase, 4)
    return compliance * (two_zeta * w3 + with_force_bound(w2, base, 3))


@inlined
def w_rate_bound(segment: Segment, base: Excitation) -> float:
    """Bound on the first derivative of w."""
    return segment.bounds.u2 + base_derivative_bound(base, segment.phase, 2)


@inlined
def w_curvature_bound(dropped: int, segment: Segment, base: Excitation) -> float:
    """Bound on the second derivative of w/t^dropped over a segment of slip, for `dropped` 0 or 1.

    Let n be dropped + 2. The bound is 2/n! times the bound on the nth derivative of w.
    """
    if dropped == 0:
        return _in_slip(3, segment, base) + base_derivative_bound(base, segment.phase, 3)
    return (_in_slip(4, segment, base) + base_derivative_bound(base, segment.phase, 4)) / 3.0
