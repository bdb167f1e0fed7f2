"""The history of a march: one row a segment, where asked for."""

from typing import NamedTuple

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.dwell import approach_speed

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
)
"""Columns of a row: start [1/ω_n] within its half cycle, duration, kind of the event that ended it, state at its start."""

START, DURATION, EVENT, V, W, SLIP, WALL, GAP, P_RATE, RIDING, APPROACH = range(len(COLUMNS))
_WIDTH = len(COLUMNS)


class Log(NamedTuple):
    """Rows to fill and, in cursor[0], how many have been filled; rows beyond the end are counted, not kept."""

    rows: np.ndarray
    cursor: np.ndarray


@kernel
def empty_log(capacity):
    """Log with room for a number of segments."""
    return Log(np.empty((capacity, _WIDTH)), np.zeros(1, np.int64))


@kernel
def record(log, state, start, duration, event):
    """Append one segment."""
    i = log.cursor[0]
    log.cursor[0] = i + 1
    if i >= log.rows.shape[0]:
        return
    row = log.rows[i]
    row[0] = start
    row[1] = duration
    row[2] = event
    row[3] = state.v
    row[4] = state.w
    row[5] = state.slip
    row[6] = state.wall
    row[7] = state.gap
    row[8] = state.p_rate
    row[9] = state.riding
    row[10] = approach_speed(state.dwell)
