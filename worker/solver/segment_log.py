"""The segments of an integration and their events: one row each, on request."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.sliding import direction_of
from damperlab.worker.solver.state import State

COLUMNS = (
    "start",
    "duration",
    "event",
    "v",
    "w",
    "slip",
    "wall",
    "gap",
    "p_rate",
    "riding",
    "approach",
    "slide",
)
"""Columns of a row: start [1/ω_n] within its half cycle, duration, kind of the event that ended it, state at its
start.
"""

START, DURATION, EVENT, V, W, SLIP, WALL, GAP, P_RATE, RIDING, APPROACH, SLIDE = range(len(COLUMNS))
_WIDTH = len(COLUMNS)


class Log(NamedTuple):
    """Rows to fill and, in cursor[0], the number of rows so far; rows beyond the end are counted, not stored."""

    rows: NDArray[np.float64]
    cursor: NDArray[np.int64]


@kernel
def empty_log(capacity: int) -> Log:
    """Log with room for a number of segments."""
    return Log(np.empty((capacity, _WIDTH)), zero_counts(1))


@kernel
def append_segment(log: Log, state: State, start: float, duration: float, event: int) -> None:
    """Append one segment."""
    i = log.cursor[0]
    log.cursor[0] = i + 1
    if i >= log.rows.shape[0]:
        return
    row = log.rows[i]
    row[START] = start
    row[DURATION] = duration
    row[EVENT] = event
    row[V] = state.v
    row[W] = state.w
    row[SLIP] = state.slip
    row[WALL] = state.wall
    row[GAP] = state.gap
    row[P_RATE] = state.p_rate
    row[RIDING] = state.riding
    row[APPROACH] = approach_speed(state.dwell)
    row[SLIDE] = direction_of(state.slide)
