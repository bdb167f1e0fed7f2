"""Largest Lyapunov exponent of a response that does not repeat."""

from math import inf, log, sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import zero_matrix
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.solver.transition_log import Transitions
from damperlab.worker.steady.section.coordinates import SECTION_SIZE
from damperlab.worker.steady.stability.variational import propagate

_BATCHES = 16
# Pairs (n, g): a mean growth of more than g per cycle, over n cycles, counts as chaos.
# Most chaos is detected after few cycles.
# The limits are chosen, not derived. They require a growth by at least e^6, or by e^3 after 320 cycles.
_RUNGS = ((32, 0.2), (48, 0.15), (64, 0.125), (96, 0.1), (320, 0.01))

HALVES_FOLLOWED = 2 * 320 * (_BATCHES + 1) // _BATCHES
"""Largest number of half cycles for following a tangent vector."""


@kernel
def is_chaotic(
    state: State,
    longest: int,
    scene: Scene,
    log_: Transitions,
    size: int,
) -> bool:
    """Whether a tangent vector grows: its mean growth per cycle exceeds a limit and three standard errors.

    The growth is averaged over at most `longest` excitation cycles; at least 16 cycles are used. The vector first
    aligns with the direction of growth. This takes one sixteenth as many cycles, which are not averaged.

    Notes
    -----
    The exponent is the mean increase of ln |δz| per cycle (Benettin et al. 1980). For a quasi-periodic
    response, the exponent is 0, and the computed mean is zero within the standard error or, for slow beats,
    below 0.01 over 320 cycles.
    """
    tangent = zero_matrix(SECTION_SIZE, 1)
    tangent[0, 0] = 1.0
    if size > 2:
        tangent[2, 0] = 0.3
        tangent[3, 0] = 0.7
    growth = np.empty(HALVES_FOLLOWED)  # logarithm of the growth in each half cycle
    known = 0
    for cycles, least in _RUNGS:
        length = max(min(cycles, longest) // _BATCHES, 1)
        while known < 2 * length * (_BATCHES + 1):
            log_.cursor[0] = 0
            state, outcome = half_cycle_on_addresses(state, scene, None, log_)
            if outcome != ARRIVED or log_.cursor[0] > log_.capacity:
                return False
            propagate(log_, scene, tangent)
            norm = 0.0
            for i in range(size):
                norm += tangent[i, 0] ** 2
            norm = sqrt(norm)
            if norm == 0.0 or norm == inf:
                return False
            growth[known] = log(norm)
            known += 1
            for i in range(SECTION_SIZE):
                tangent[i, 0] /= norm
        mean, error = _mean_growth(growth, length)
        if mean > max(least, 3.0 * error):
            return True
    return False


@kernel
def _mean_growth(growth: NDArray[np.float64], length: int) -> tuple[float, float]:
    """Mean growth per cycle and its standard error, from batches of `length` cycles, without the first batch."""
    total = 0.0
    square = 0.0
    for batch in range(1, _BATCHES + 1):
        gained = 0.0
        for half in range(2 * length * batch, 2 * length * (batch + 1)):
            gained += growth[half]
        gained /= length
        total += gained
        square += gained * gained
    mean = total / _BATCHES
    variance = max(square / _BATCHES - mean * mean, 0.0)
    return mean, sqrt(variance / (_BATCHES - 1))
