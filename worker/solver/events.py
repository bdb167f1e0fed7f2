"""Kinds of events, counters of events in an integration, and outcomes of an integration."""

from enum import IntEnum

from damperlab.studies.variables import Status

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


class Outcome(IntEnum):
    """Outcome of an integration, with values of `Status`."""

    ARRIVED = Status.CONVERGED
    OUT_OF_EVENTS = Status.TOO_MANY_EVENTS
    STALLED = Status.NO_PROGRESS


# The outcomes as plain integers, for kernels.
ARRIVED = int(Outcome.ARRIVED)
OUT_OF_EVENTS = int(Outcome.OUT_OF_EVENTS)
STALLED = int(Outcome.STALLED)
