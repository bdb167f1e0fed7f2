"""Log of the segments of an integration, with one row per segment."""

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
"""Columns of a row: start of the segment within the half cycle [1/ω_n], duration [1/ω_n], kind of the event at the end,
and state at the start.
"""

START, DURATION, EVENT, V, W, SLIP, WALL, GAP, P_RATE, RIDING, APPROACH, SLIDE = range(len(COLUMNS))
_WIDTH = len(COLUMNS)


class Log(NamedTuple):
    """Segment log. cursor[0] counts all segments; rows beyond the capacity are not stored."""

    rows: NDArray[np.float64]
    cursor: NDArray[np.int64]


@kernel
def empty_log(capacity: int) -> Log:
    """Make an empty log for at most `capacity` segments."""
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
