"""A scene of addresses: what a march is handed holds nothing that is counted."""

from typing import Any

import pytest
from numba import typeof
from numba.core.registry import cpu_target

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.scene import make_scene

PARTICLE = Particle(2.0, 0.6, 0.2)


@pytest.mark.parametrize("friction", [None, 0.3])
@pytest.mark.parametrize("particle", [None, PARTICLE, PARTICLE._replace(wall=Wall(400.0, 4.0))])
def test_the_addresses_of_a_scene_leave_no_array_in_it(
    friction: float | None, particle: Particle | None
) -> None:
    """One array among them cost a march a seventh of its run time, in references counted at every event."""
    scene = typeof(make_scene(0.02, 0.97, friction, particle, True))
    models = cpu_target.target_context.data_model_manager
    assert models[scene].contains_nrt_meminfo()
    kernel: Any = taken
    part = kernel._part
    part.compile((scene,))
    assert not models[part.overloads[(scene,)].signature.return_type].contains_nrt_meminfo()


@kernel
def taken(scene: Any) -> Any:
    return on_addresses(scene)
