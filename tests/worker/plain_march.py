"""Plain marching, the slow way that needs no idea of a steady response: what the search for one is compared with."""

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.events import ARRIVED, BUDGET
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.observe.meter import METERS, PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.scene import make_scene


@kernel
def march_plainly(damping_ratio, frequency_ratio, friction, particle, state, silent, peaks):
    """March from a state at phase 0: `silent` cycles, then one for each row of `peaks`.

    Parameters
    ----------
    damping_ratio, frequency_ratio, friction, particle
        As in `damperlab.worker.steady.settle.settle`.
    state : State
        Where to start.
    silent : int
        Cycles before peaks are noted.
    peaks : array, shape (cycles, 2)
        Filled with the largest |u| and |v| of each cycle.

    Returns
    -------
    state : State
        At the end.
    outcome : int
        ARRIVED, or how the march ended early.
    """
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, None)
    sums = np.zeros(METERS)
    meter = Meter(sums, None, None)
    scene.counts[BUDGET] = 2000 * (silent + peaks.shape[0] + 50)
    outcome = ARRIVED
    for _ in range(2 * silent):
        state, outcome = half_cycle(state, scene, None, None)
        if outcome != ARRIVED:
            return state, outcome
    for cycle in range(peaks.shape[0]):
        sums[PEAK] = 0.0
        sums[RELATIVE_PEAK] = 0.0
        for _ in range(2):
            state, outcome = half_cycle(state, scene, meter, None)
            if outcome != ARRIVED:
                return state, outcome
        peaks[cycle, 0] = sums[PEAK]
        peaks[cycle, 1] = sums[RELATIVE_PEAK]
    return state, outcome
