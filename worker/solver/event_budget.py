"""Limits on the number of events in an integration, and on successive events without progress in time."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.events import ARRIVED, BUDGET, IDLE, OUT_OF_EVENTS, SEGMENTS, STALLED

# Largest number of successive events without progress in time.
_MOST_IDLE = 64
_NO_TIME = 1e-15  # a segment of at most this length, relative to `scale`, makes no progress in time


@inlined
def spend(counts: NDArray[np.int64], time: float, scale: float) -> int:
    """Return ARRIVED if the integration may continue after a segment of length `time`, else the reason for its end."""
    if counts[SEGMENTS] > counts[BUDGET]:
        return OUT_OF_EVENTS
    if time <= _NO_TIME * scale:
        counts[IDLE] += 1
        if counts[IDLE] > _MOST_IDLE:
            return STALLED
    else:
        counts[IDLE] = 0
    return ARRIVED
