"""Plain marching, the slow way that needs no idea of a steady response: what the search for one is compared with."""

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.contact.media import make_loaded
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.propagator import make_base, make_medium
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.state import (
    ARRIVED,
    BUDGET,
    COUNTS,
    METERS,
    PEAK,
    RELATIVE_PEAK,
    Meter,
)


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
    base = make_base(damping_ratio, frequency_ratio, None)
    free = make_medium(base, 1.0, None)
    loaded = None
    if particle is not None:
        loaded = make_loaded(base, particle, particle.wall, None)
    work = np.empty((4, TERMS))
    counts = np.zeros(COUNTS, np.int64)
    sums = np.zeros(METERS)
    meter = Meter(sums, None)
    counts[BUDGET] = 2000 * (silent + peaks.shape[0] + 50)
    outcome = ARRIVED
    for _ in range(2 * silent):
        state, outcome = half_cycle(state, base, free, loaded, friction, particle, work, counts, None, None)
        if outcome != ARRIVED:
            return state, outcome
    for cycle in range(peaks.shape[0]):
        sums[PEAK] = 0.0
        sums[RELATIVE_PEAK] = 0.0
        for _ in range(2):
            state, outcome = half_cycle(
                state, base, free, loaded, friction, particle, work, counts, meter, None
            )
            if outcome != ARRIVED:
                return state, outcome
        peaks[cycle, 0] = sums[PEAK]
        peaks[cycle, 1] = sums[RELATIVE_PEAK]
    return state, outcome
