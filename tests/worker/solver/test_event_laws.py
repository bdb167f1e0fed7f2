"""Events: the first of several, bounds on the motion between them, proofs that there is none, the end of a chatter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.worker.forms import EPS, FIXED, both, in_form
from tests.worker.plain_march import marched

from damperlab.worker.solver.contact.chatter import is_chatter_over
from damperlab.worker.solver.detection.bounds import motion_bounds, u_derivative_bound, w_curvature_bound
from damperlab.worker.solver.detection.event_free import is_free_between, is_free_from
from damperlab.worker.solver.excitation.excitation import (
    base_derivative_bound,
    expand_base,
    largest_to_hold,
    phase_of_sine,
)
from damperlab.worker.solver.excitation.sine import make_sine
from damperlab.worker.solver.linear_motion import make_linear_motion
from damperlab.worker.solver.motion.taylor import TERMS, combine
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import MotionBounds, Regime, Segment, Span, regime_of
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import State
from damperlab.worker.steady.start import at_rest


@pytest.mark.parametrize("forced", [True, False])
def test_a_slip_of_next_to_no_excess_goes_next_to_nowhere(forced: bool) -> None:
    """A held mass that the largest force P moves by an excess x slips for √(18x/P)/r, and by 4.5 x²/(P r²), towards zero.

    To first order in x/P. Of 2,000 frequencies, margins and excesses, the shortest slips last a millionth of a window, and
    begin anywhere in one.
    """
    random = np.random.default_rng(3)
    for _ in range(2000):
        r = 10.0 ** random.uniform(-1.0, 1.0)
        largest = 1.0 if forced else r * r
        edge = largest * random.choice([1e-9, 1e-3, 0.2])
        excess = largest * 10.0 ** random.uniform(-13.0, -3.0)
        v = random.choice([-1.0, 1.0]) * (edge + excess)
        held = State(v, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0, 0, None)
        end = marched(0.01, r, largest + edge, None, held, 2, forced)
        inwards = abs(v) - abs(end.v)
        # the excess is known to the rounding of forces; the spring takes its share, damping and higher orders a tenth
        known = 4e-15 * (largest + edge)
        stiffness = 4.5 / (largest * r * r)
        less = 0.9 - stiffness * excess
        assert inwards >= less * stiffness * max(excess - known, 0.0) ** 2 - known, (r, edge, excess)
        assert inwards <= 1.1 * stiffness * (excess + known) ** 2 + known, (r, edge, excess)


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


@both
@pytest.mark.parametrize(("friction", "free"), [(1.5, True), (0.5, False)])
def test_a_particle_at_rest_on_a_mass_that_is_held_has_no_event(
    form: str, friction: float, free: bool
) -> None:
    """Nothing pushes it and nothing will, unless the force tears the mass loose."""
    scene = make_scene(0.02, 1.0, friction, Particle(1.0, 0.5, 0.1), True, True)
    base = scene.base
    state = State(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0, 0, None)
    angle = 0.5 * np.pi
    start, end = (phase_of_sine(base, np.sin(at), 0.0) for at in (angle, angle + base.window))
    segment = Segment(state, state, start, end, regime_of(state, scene), base.window, MotionBounds(0.0, 0.0))
    assert in_form(is_free_between, form)(segment, scene) == free
    assert in_form(is_free_from, form)(segment, scene) == free


def test_a_force_that_friction_takes_has_no_inertia() -> None:
    particle = Particle(1.0, 0.5, 0.1)
    forced, shaken = (make_scene(0.02, 2.0, 0.5, particle, True, force).base for force in (True, False))
    assert largest_to_hold(forced, 1e12) == 1.0
    assert largest_to_hold(shaken, 1.1) == 4.0 * 1.1


@pytest.mark.parametrize(("forced", "over"), [(False, True), (True, False)])
def test_the_rate_of_a_force_changes_the_push(forced: bool, over: bool) -> None:
    """At rest and without damping only a force changes the acceleration: by r a unit of time, here a hundredth of it."""
    r = 1.0
    particle = Particle(1.0, 0.5, 0.1)
    scene = make_scene(0.0, r, None, particle, True, forced)
    left = (
        4e-6 * scene.base.window
    )  # more than is ended whatever happens, less than is ended under a steady push
    closing = 100.0 * left * r
    leaving = 0.5 * (1.0 - particle.restitution) * left * closing
    assert is_chatter_over(0.0, leaving, 0.0, closing, scene, particle) == over
