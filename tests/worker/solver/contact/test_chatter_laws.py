"""When a chatter is over: whatever changes the wall's acceleration until then is in the bound."""

import pytest

from damperlab.worker.solver.contact.chatter import is_chatter_over
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene


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
