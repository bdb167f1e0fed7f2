"""Limits on the number of events of an integration, and on successive events without progress in time."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.events import ARRIVED, BUDGET, IDLE, OUT_OF_EVENTS, SEGMENTS, STALLED

_MOST_IDLE = 64  # events without progress in time before the integration gives up
_NO_TIME = 1e-15  # largest segment, relative to `scale`, that counts as no progress


@inlined
def spend(counts: NDArray[np.int64], time: float, scale: float) -> int:
    """Outcome after a segment of the given length, which `counts` already includes: ARRIVED to continue."""
    if counts[SEGMENTS] > counts[BUDGET]:
        return OUT_OF_EVENTS
    if time <= _NO_TIME * scale:
        counts[IDLE] += 1
        if counts[IDLE] > _MOST_IDLE:
            return STALLED
    else:
        counts[IDLE] = 0
    return ARRIVED
