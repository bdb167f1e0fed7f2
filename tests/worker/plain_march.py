"""Plain marching, the slow way that needs no idea of a steady response: what the search for one is compared with.

Thousands of cycles go through a kernel of the report on accuracy, a few through that of an orbit, which is compiled anyway.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.accuracy.march import march_halves
from damperlab.worker.accuracy.steady_answers import Point
from damperlab.worker.solver.events import ARRIVED, BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import make_scene
from damperlab.worker.solver.segment_log import empty_log
from damperlab.worker.solver.state import State


def marched(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    state: State,
    halves: int,
    forced: bool = False,
) -> State:
    """March on by half cycles, with everything made anew that a march needs, and with the kernel of an orbit."""
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, True, forced)
    scene.counts[BUDGET] = 100_000 * halves
    log = empty_log(1000)
    for _ in range(halves):
        log.cursor[0] = 0
        state, outcome = half_cycle(state, scene, None, log)
        assert outcome == ARRIVED
    return state


def plain_end(point: Point, state: State, cycles: int) -> State:
    """State some cycles later."""
    end, outcome = march_halves(*point, state, 2 * cycles, np.empty((0, 3)))
    assert outcome == ARRIVED
    return State(*end)


def plain_means(point: Point, period: int, cycles: int) -> NDArray[np.float64]:
    """Mean peak of each period, from rest on, in at most so many cycles; of cycles that begin at every half cycle."""
    count = 2 * period * (cycles // period)
    halves = np.empty((count + 1, 3))
    _, outcome = march_halves(*point, point.rest(), 0, halves)
    assert outcome == ARRIVED
    windows = np.maximum(halves[:-1, 0], halves[1:, 0])
    means: NDArray[np.float64] = windows.reshape(-1, 2 * period).mean(axis=1)
    return means
