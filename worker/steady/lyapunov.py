"""Largest Lyapunov exponent of a response that does not repeat."""

from math import inf, log, sqrt

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import ARRIVED, State
from damperlab.worker.solver.transitions import Transitions
from damperlab.worker.steady.variational import SIZE, propagate

_BATCHES = 16


@kernel
def is_chaotic(
    state: State,
    cycles: int,
    least: float,
    scene: Scene,
    log_: Transitions,
    size: int,
) -> bool:
    """Whether a tangent vector grows: mean growth a cycle above zero by three standard errors and by `least`.

    Parameters
    ----------
    state : State
        On the attractor.
    cycles : int
        Excitation cycles over which the growth is averaged; one sixteenth more go before, to turn the vector.
    least : float
        Growth a cycle that counts.

    Notes
    -----
    The exponent is the mean of ln |δz| gained per cycle (Benettin et al. 1980). A quasi-periodic response has exponent
    0: its mean then lies within its error, or below `least`: 0.01 tells slow beats from chaos over 320 cycles.
    """
    tangent = np.zeros((SIZE, 1))
    tangent[0, 0] = 1.0
    if size > 2:
        tangent[2, 0] = 0.3
        tangent[3, 0] = 0.7
    length = max(cycles // _BATCHES, 1)
    total = 0.0
    square = 0.0
    for batch in range(_BATCHES + 1):
        growth = 0.0
        for _ in range(2 * length):
            log_.cursor[0] = 0
            state, outcome = half_cycle(state, scene, None, log_)
            if outcome != ARRIVED or log_.cursor[0] > log_.capacity:
                return False
            propagate(log_, scene.base, scene.free, scene.loaded, scene.friction, scene.particle, tangent)
            norm = 0.0
            for i in range(size):
                norm += tangent[i, 0] ** 2
            norm = sqrt(norm)
            if norm == 0.0 or norm == inf:
                return False
            growth += log(norm)
            for i in range(SIZE):
                tangent[i, 0] /= norm
        if batch > 0:
            growth /= length
            total += growth
            square += growth * growth
    mean = total / _BATCHES
    variance = max(square / _BATCHES - mean * mean, 0.0)
    return mean > max(least, 3.0 * sqrt(variance / (_BATCHES - 1)))
