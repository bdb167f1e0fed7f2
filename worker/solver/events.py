"""Events: their kinds, their counts in an integration, and its outcomes."""

from enum import IntEnum

from damperlab.studies.variables import Status

# Kinds of event that end a segment.
NOTHING = 0
TURN = 1
SLIP_ONSET = 2
NEAR_WALL = 3
FAR_WALL = 4
RELEASE = 5
LET_GO = 6  # end of a dwell
CLEARANCE = 7  # the particle is clear of a compliant wall
PUSHED_AGAIN = 8  # a compliant wall pushes again
REST = 9  # a particle with friction has come to rest in its cavity

# Counts of events in an integration (int64 array of COUNTS entries).
IMPACTS = 0
TURNS = 1
ATTACHMENTS = 2
SEGMENTS = 3
IDLE = 4
BUDGET = 5
COUNTS = 6


class Outcome(IntEnum):
    """Outcome of an integration: the values of `Status` that can end one, with the same numbers."""

    ARRIVED = Status.CONVERGED
    OUT_OF_EVENTS = Status.TOO_MANY_EVENTS
    STALLED = Status.NO_PROGRESS


# The members as plain numbers, for kernels.
ARRIVED = int(Outcome.ARRIVED)
OUT_OF_EVENTS = int(Outcome.OUT_OF_EVENTS)
STALLED = int(Outcome.STALLED)
