"""Bounds on the motion hold on every motion within a window, and so do those on the base."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form

from damperlab.worker.solver.detection.bounds import motion_bounds, u_derivative_bound, w_curvature_bound
from damperlab.worker.solver.excitation.excitation import base_derivative_bound, expand_base, phase_of_sine
from damperlab.worker.solver.excitation.sine import make_sine
from damperlab.worker.solver.linear_motion import make_linear_motion
from damperlab.worker.solver.motion.taylor import TERMS, combine
from damperlab.worker.solver.regime import MotionBounds, Regime, Segment, Span
from damperlab.worker.steady.start import at_rest

numbers = st.floats(-5, 5)
PLACES = np.linspace(0.0, 1.0, 33)


@both
@FIXED
@given(
    damping=st.floats(0, 1),
    r=st.floats(0.1, 10),
    inertia=st.floats(1, 2),
    x=numbers,
    w=numbers,
    angle=st.floats(0, 6.2),
    share=st.floats(0.01, 1.0),
)
def test_no_motion_leaves_its_bounds(
    form: str, damping: float, r: float, inertia: float, x: float, w: float, angle: float, share: float
) -> None:
    base = make_sine(damping, r, None)
    motion = make_linear_motion(base, inertia, None)
    span = share * base.window
    phase = phase_of_sine(base, np.sin(angle), np.cos(angle))
    state, regime = at_rest(r, None, None)._replace(v=x, w=w), Regime(False, 0.0, motion)
    bounds = in_form(motion_bounds, form)(state, regime, Span(phase, phase, span, False), base)
    slips = Segment(state, state, phase, phase, regime, span, bounds)
    sticks = slips._replace(regime=Regime(True, 0.0, motion), bounds=MotionBounds(0.0, 0.0))
    relative, absolute, base_polynomial = np.empty(TERMS), np.empty(TERMS), np.empty(TERMS)
    combine(x, w, phase.first, phase.second, motion.relative_rows, relative)
    combine(x, w, phase.first, phase.second, motion.absolute_rows, absolute)
    expand_base(base, phase, base_polynomial)
    at = PLACES * span
    derive = np.polynomial.polynomial

    def most(p: np.ndarray, order: int) -> float:
        values = derive.polyval(at, derive.polyder(p, order) if order else p)
        return float(np.abs(values).max()) * (1 - 64 * EPS)

    assert most(relative, 1) <= bounds.w
    assert most(absolute, 2) <= bounds.u2
    for order in (2, 3, 4, 5):
        assert most(absolute, order) <= in_form(u_derivative_bound, form)(order, slips, base)
        of_base = base_derivative_bound(base, phase, order)
        assert most(base_polynomial, order) <= of_base
        assert in_form(u_derivative_bound, form)(order, sticks, base) == of_base
    assert most(relative, 3) <= in_form(w_curvature_bound, form)(0, slips, base)
