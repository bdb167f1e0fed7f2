"""A motion has the same bits whatever is measured or logged; what a march is handed holds nothing that is counted."""

from typing import Any

import numpy as np
import pytest
from numba import typeof
from numba.core.registry import cpu_target
from tests.worker.forms import night

from damperlab.studies.variables import Status
from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.events import ARRIVED, BUDGET, OUT_OF_EVENTS, STALLED
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, Meter
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.state import State
from damperlab.worker.steady.start import at_rest

FRICTION, R = 0.3, 0.97
PARTICLE = Particle(2.0, 0.6, 0.2)


def test_a_motion_has_the_same_bits_with_and_without_a_meter() -> None:
    """That a log changes no bits is shown in `tests/worker/steady/test_steady_truth.py`, which marches without one."""
    ends: list[State] = []
    log = empty_log(10_000)
    for meter in (None, Meter(np.zeros(METERS))):
        scene = make_scene(0.02, R, FRICTION, PARTICLE, True)
        scene.counts[BUDGET] = 10**6
        state = at_rest(R, FRICTION, PARTICLE)
        for _ in range(80):
            log.cursor[0] = 0
            state, outcome = half_cycle(state, scene, meter, log)
            assert outcome == ARRIVED
        ends.append(State(*state))
    assert ends[0] == ends[1]


def test_every_outcome_is_a_status_by_its_number() -> None:
    outcomes = (ARRIVED, OUT_OF_EVENTS, STALLED)
    assert [Status(outcome).name for outcome in outcomes] == ["CONVERGED", "TOO_MANY_EVENTS", "NO_PROGRESS"]


@pytest.mark.parametrize("friction", [None, 0.3])
@pytest.mark.parametrize("particle", [None, PARTICLE, night(PARTICLE._replace(wall=Wall(400.0, 4.0)))])
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
