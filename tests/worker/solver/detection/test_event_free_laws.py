"""Proofs that a segment is free of events."""

import numpy as np
import pytest
from tests.worker.forms import both, in_form

from damperlab.worker.solver.detection.event_free import is_free_between, is_free_from
from damperlab.worker.solver.excitation.excitation import largest_to_hold, phase_of_sine
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import MotionBounds, Segment, regime_of
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.state import State


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
