"""Log of the transitions in a half cycle, for the variational equations.

Between two transitions the motion is linear, and its state-transition matrix depends only on the time. So panels
without events need not be logged.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats, on_addresses
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.excitation.excitation import Phase
from damperlab.worker.solver.segment_log import Log, append_segment
from damperlab.worker.solver.sliding import direction_of, down_of
from damperlab.worker.solver.state import State

SPAN, EVENT, INERTIA_FORCE, BASE_RATE, FORCE, V = range(6)
"""Columns of a row: time since the previous transition [1/ω_n], kind of the event at the end of this time, and −s'',
s', the exciting force and v at the event.
"""

BEFORE = 6
AFTER = 15
"""First columns of the states just before and just after the event."""

W, SLIP, RIDING, WALL, GAP, P_RATE, SPEED, SLIDE, DOWN = range(9)
"""Columns of a state, counted from BEFORE or AFTER; SPEED is from `Dwell`, SLIDE and DOWN are from `Slide`."""

WIDTH = 24


class Transitions(NamedTuple):
    """Transition log. cursor[0] counts all rows; rows beyond the capacity are not stored.

    Attributes
    ----------
    rows : array, shape (capacity · WIDTH,)
        One row per transition, and a row of kind NOTHING at the end of a half cycle or of a span in contact with a
        compliant wall.
    cursor : int64 array, shape (1,)
    capacity : int
        Largest number of rows.
    """

    rows: NDArray[np.float64]
    cursor: NDArray[np.int64]
    capacity: int


@kernel
def empty_transitions(capacity: int) -> Transitions:
    """Make an empty log for at most `capacity` transitions."""
    return Transitions(np.empty(capacity * WIDTH), zero_counts(1), capacity)


@inlined
def log_on_addresses(log: Any) -> Any:
    """Replace the arrays of `Transitions` by addresses, and return any other log unchanged.

    The arrays must outlive the result.
    """
    if isinstance(log, Transitions):
        return on_addresses(log)
    return log


@inlined
def note_segment(
    log: Log | Transitions | None, state: State, start: float, duration: float, event: int
) -> None:
    """Append a segment if the log is a `Log`; otherwise do nothing."""
    if isinstance(log, Log):
        append_segment(log, state, start, duration, event)


@inlined
def note_transition(
    log: Log | Transitions | None, span: float, event: int, before: State, after: State, phase: Phase
) -> None:
    """Append a transition if the log is `Transitions`; otherwise do nothing."""
    if isinstance(log, Transitions):
        _append(log, span, event, before, after, phase)


@inlined
def _append(log: Transitions, span: float, event: int, before: State, after: State, phase: Phase) -> None:
    i = log.cursor[0]
    log.cursor[0] = i + 1
    if i >= log.capacity:
        return
    at = i * WIDTH
    rows = log.rows
    rows[at + SPAN] = span
    rows[at + EVENT] = event
    rows[at + INERTIA_FORCE] = phase.inertia_force
    rows[at + BASE_RATE] = phase.rate
    rows[at + FORCE] = phase.force
    rows[at + V] = before.v
    _side(rows, at + BEFORE, before)
    _side(rows, at + AFTER, after)


@inlined
def _side(rows: Floats, at: int, state: State) -> None:
    rows[at + W] = state.w
    rows[at + SLIP] = state.slip
    rows[at + RIDING] = state.riding
    rows[at + WALL] = state.wall
    rows[at + GAP] = state.gap
    rows[at + P_RATE] = state.p_rate
    rows[at + SPEED] = approach_speed(state.dwell)
    rows[at + SLIDE] = direction_of(state.slide)
    rows[at + DOWN] = down_of(state.slide)
