"""Log of the transitions in a half cycle, for the variational equations.

Between two transitions the motion is linear, and its state-transition matrix depends only on the time. So panels
without events need not be logged.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.excitation.excitation import Phase
from damperlab.worker.solver.segment_log import Log, append_segment
from damperlab.worker.solver.sliding import direction_of, down_of
from damperlab.worker.solver.state import State


class Side(NamedTuple):
    """The state on one side of a transition; `speed` is from `Dwell`, `slide` and `down` are from `Slide`."""

    w: float
    slip: float
    riding: float
    wall: float
    gap: float
    p_rate: float
    speed: float
    slide: float
    down: float


class Transition(NamedTuple):
    """A transition.

    Attributes
    ----------
    span : float
        Time since the previous transition [1/ω_n].
    event : float
        Kind of the event at the end of this time.
    inertia_force, base_rate, force, v : float
        −s'', s', the exciting force and v at the event.
    before, after : Side
        The state just before and just after the event.
    """

    span: float
    event: float
    inertia_force: float
    base_rate: float
    force: float
    v: float
    before: Side
    after: Side


_BEFORE = 6
_AFTER = 15
_WIDTH = 24


class Transitions(NamedTuple):
    """Transition log. cursor[0] counts all rows; rows beyond the capacity are not stored.

    Attributes
    ----------
    rows : array, shape (capacity · _WIDTH,)
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
    return Transitions(np.empty(capacity * _WIDTH), zero_counts(1), capacity)


@inlined
def transition_at(rows: Floats, i: int) -> Transition:
    """Transition i of a log."""
    at = i * _WIDTH
    before, after = _side_at(rows, at + _BEFORE), _side_at(rows, at + _AFTER)
    return Transition(
        rows[at], rows[at + 1], rows[at + 2], rows[at + 3], rows[at + 4], rows[at + 5], before, after
    )


@inlined
def _side_at(rows: Floats, at: int) -> Side:
    return Side(
        rows[at],
        rows[at + 1],
        rows[at + 2],
        rows[at + 3],
        rows[at + 4],
        rows[at + 5],
        rows[at + 6],
        rows[at + 7],
        rows[at + 8],
    )


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
        i = log.cursor[0]
        log.cursor[0] = i + 1
        if i >= log.capacity:
            return
        at = i * _WIDTH
        at_event = (span, float(event), phase.inertia_force, phase.rate, phase.force, before.v)
        for column in range(_BEFORE):
            log.rows[at + column] = at_event[column]
        _write_side(log.rows, at + _BEFORE, before)
        _write_side(log.rows, at + _AFTER, after)


@inlined
def _write_side(rows: Floats, at: int, state: State) -> None:
    speed, slide, down = approach_speed(state.dwell), direction_of(state.slide), down_of(state.slide)
    side = (state.w, state.slip, state.riding, state.wall, state.gap, state.p_rate, speed, slide, down)
    for column in range(_AFTER - _BEFORE):
        rows[at + column] = side[column]
