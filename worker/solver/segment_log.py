"""Log of the segments of an integration, with one row per segment."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.sliding import direction_of
from damperlab.worker.solver.state import State


class Logged(NamedTuple):
    """A logged segment, or the columns of a log.

    Attributes
    ----------
    start, duration : float
        Start of the segment within the half cycle, and its duration [1/ω_n].
    event : float
        Kind of the event at the end.
    v, w, slip, wall, gap, p_rate, riding : float
        State at the start.
    approach, slide : float
        `Dwell.speed` and `Slide.direction` at the start; 0 without dwell and slide.
    """

    start: Any
    duration: Any
    event: Any
    v: Any
    w: Any
    slip: Any
    wall: Any
    gap: Any
    p_rate: Any
    riding: Any
    approach: Any
    slide: Any


_WIDTH = len(Logged._fields)


class Log(NamedTuple):
    """Segment log. cursor[0] counts all segments; rows beyond the capacity are not stored."""

    rows: NDArray[np.float64]
    cursor: NDArray[np.int64]
    capacity: int


@kernel
def empty_log(capacity: int) -> Log:
    """Make an empty log for at most `capacity` segments."""
    return Log(np.empty((capacity, _WIDTH)), zero_counts(1), capacity)


def stored_rows(log: Log) -> NDArray[np.float64]:
    """Return the stored rows, shape (segments, columns), with the columns in the order of `Logged`."""
    return log.rows[: log.cursor[0]]


@inlined
def append_segment(log: Log, state: State, start: float, duration: float, event: int) -> None:
    """Append one segment to a log whose arrays are addresses."""
    i = log.cursor[0]
    log.cursor[0] = i + 1
    if i >= log.capacity:
        return
    v, w, slip, wall, gap, p_rate, riding, _, _, dwell, slide = state
    approach, direction = approach_speed(dwell), direction_of(slide)
    row = (start, duration, float(event), v, w, slip, wall, gap, p_rate, riding, approach, direction)
    for column in range(_WIDTH):
        log.rows[i * _WIDTH + column] = row[column]
