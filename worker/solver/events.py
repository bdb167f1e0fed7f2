"""Kinds of events, counters of events and their limits, and outcomes of an integration."""

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import Status
from damperlab.worker.jit import inlined

# Kinds of event that end a segment.
NOTHING = 0
TURN = 1
SLIP_ONSET = 2
NEAR_WALL = 3
FAR_WALL = 4
RELEASE = 5
LET_GO = 6  # End of a dwell.
CLEARANCE = 7  # The particle is clear of a compliant wall.
PUSHED_AGAIN = 8  # A compliant wall pushes again.
REST = 9  # A particle with friction has come to rest in its cavity.

# Indices into the event counts of an integration, an int64 array of length COUNTS.
IMPACTS = 0
TURNS = 1
ATTACHMENTS = 2
SEGMENTS = 3
IDLE = 4
BUDGET = 5
COUNTS = 6


# Outcomes of an integration: values of `Status`, as plain integers for kernels.
ARRIVED = int(Status.CONVERGED)
OUT_OF_EVENTS = int(Status.TOO_MANY_EVENTS)
STALLED = int(Status.NO_PROGRESS)

_MOST_IDLE = 64  # largest number of successive events without progress in time
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
