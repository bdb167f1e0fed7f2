"""Plain marching, the slow way that needs no idea of a steady response: what the search for one is compared with.

With a kernel of the report on accuracy, which `damperlab warm` has compiled.
"""

import numpy as np
from numpy.typing import NDArray
from tests.worker.designs_drawn import Point

from damperlab.worker.accuracy.march import march_halves
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.state import State


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
