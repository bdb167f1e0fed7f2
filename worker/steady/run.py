"""A run of whole half cycles: what it is integrated in, what it remembers, and how it goes on."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import (
    ARRIVED,
    BUDGET,
    COUNTS,
    FRICTION_LOSS,
    IDLE,
    IMPACT_LOSS,
    IMPACTS,
    METERS,
    PEAK,
    RELATIVE_PEAK,
    SEGMENTS,
    SPEED,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.transitions import Transitions, empty_transitions
from damperlab.worker.steady.energy import stored_energy
from damperlab.worker.steady.orbit import coordinates
from damperlab.worker.steady.section import LONGEST, RING
from damperlab.worker.steady.variational import SIZE

EVENTS_PER_CYCLE = 100
"""Events for which a run has room on the average of its longest, `max_cycles`: beyond it ends early, with what it measured."""

# A cycle, and a window of it, over one chunk: beyond it impacts follow each other too fast to resolve.
_EVENTS_AT_ONCE = 2000
_EVENTS_PER_WINDOW = 4
_WINDOWS_PER_EVENT = 128  # event-free windows that take about as long as one event
_LOG_ROWS = 4096

# Columns of a trace: of the half cycle alone,
HALF_PEAK = 0
HALF_RELATIVE_PEAK = 1
HALF_SPEED = 2
# and totals since metering began, with the energy stored at the end of the half cycle.
IMPACTS_SO_FAR = 3
STORED = 4
_TOTALS = 5  # the first of the meter's totals, in the order of the meter
_COLUMNS = _TOTALS + 6
_METERED = (WORK_IN, VISCOUS_LOSS, FRICTION_LOSS, IMPACT_LOSS, SQUARE, STUCK)


class Notes(NamedTuple):
    """What a run remembers.

    Attributes
    ----------
    ring : array, shape (RING, SIZE)
        The last section points.
    before : array, shape (LONGEST + 1,)
        The recurrence of each period at the last look.
    trace : array, shape (half cycles + 1, columns)
        One row a metered half cycle; row 0 is the beginning.
    cycles : array, shape (cycles, 2)
        Per metered cycle, the mean of the peaks of |u| and |v| over the two windows of a whole cycle that begin in it.
    series : array, shape (cycles,)
        Scratch for other series per cycle.
    meter : Meter
        Sums over the metered half cycles.
    log : Transitions
        The transitions of one half cycle, for its Jacobian.
    monodromy : array, shape (SIZE, SIZE)
        Jacobian of the last orbit.
    orbit, departure : array, shape (SIZE,)
        Section point of the orbit that waits to be confirmed, and how far from it the run was then.
    """

    ring: NDArray[np.float64]
    before: NDArray[np.float64]
    trace: NDArray[np.float64]
    cycles: NDArray[np.float64]
    series: NDArray[np.float64]
    meter: Meter
    log: Transitions
    monodromy: NDArray[np.float64]
    orbit: NDArray[np.float64]
    departure: NDArray[np.float64]


class Stretch(NamedTuple):
    """Totals over metered half cycles of a trace, from row `first` to row `last`.

    Attributes
    ----------
    first, last : int
        Rows.
    impacts : float
    work, viscous, friction, impact : float
        Work done by the base and losses, over k Z².
    square, stuck : float
        ∫u² dτ, and the time in which friction holds the mass.
    stored_before, stored_after : float
        Energy stored at the ends.
    speed, peak, relative_peak : float
        Largest impact speed, |u| and |v|.
    """

    first: int
    last: int
    impacts: float
    work: float
    viscous: float
    friction: float
    impact: float
    square: float
    stuck: float
    stored_before: float
    stored_after: float
    speed: float
    peak: float
    relative_peak: float


@kernel
def beside(scene):
    """The same scene for what looks for orbits beside the run: counts of its own, so that the run's are never touched."""
    base, free, loaded, friction, particle, _, _ = scene
    return Scene(base, free, loaded, friction, particle, np.empty((4, TERMS)), np.zeros(COUNTS, np.int64))


@kernel
def begin_beside(probe, scene, halves):
    """Begin a search beside the run: as many impacts as the run has seen, and room for the events of some half cycles."""
    probe.counts[:] = 0
    probe.counts[IMPACTS] = scene.counts[IMPACTS]
    probe.counts[BUDGET] = _room(scene, halves)


@kernel
def _room(scene, halves):
    """Events for which some half cycles have room."""
    return halves * (_EVENTS_AT_ONCE // 2 + _EVENTS_PER_WINDOW * scene.base.windows)


@kernel
def make_notes(max_cycles, energies):
    """Empty notes of a run."""
    cycles = max_cycles + LONGEST
    return Notes(
        np.zeros((RING, SIZE)),
        np.full(LONGEST + 1, inf),
        np.empty((2 * cycles + 1, _COLUMNS)),
        np.empty((cycles, 2)),
        np.empty(cycles),
        Meter(np.zeros(METERS), energies),
        empty_transitions(_LOG_ROWS),
        np.eye(SIZE),
        np.zeros(SIZE),
        np.zeros(SIZE),
    )


@kernel
def work_done(scene, half):
    """Work of a run so far, in events: a count, not a clock, so that the same study has the same bits everywhere."""
    return scene.counts[SEGMENTS] + half * scene.base.windows // _WINDOWS_PER_EVENT


@kernel
def begin_trace(state, scene, notes):
    """Begin to meter: row 0 of the trace."""
    notes.meter.sums[:] = 0.0
    notes.trace[0, :] = 0.0
    notes.trace[0, IMPACTS_SO_FAR] = scene.counts[IMPACTS]
    notes.trace[0, STORED] = stored_energy(state, scene.base.frequency_ratio, scene.particle)


@kernel
def _note(row, state, scene, notes):
    """Write one row of the trace."""
    sums = notes.meter.sums
    line = notes.trace[row]
    line[HALF_PEAK] = sums[PEAK]
    line[HALF_RELATIVE_PEAK] = sums[RELATIVE_PEAK]
    line[HALF_SPEED] = sums[SPEED]
    line[IMPACTS_SO_FAR] = scene.counts[IMPACTS]
    line[STORED] = stored_energy(state, scene.base.frequency_ratio, scene.particle)
    for i in range(6):
        line[_TOTALS + i] = sums[_METERED[i]]


@kernel
def metered_half(state, row, scene, notes):
    """One half cycle with the meter on, into row `row` of the trace."""
    meter = notes.meter
    meter.sums[PEAK] = 0.0
    meter.sums[RELATIVE_PEAK] = 0.0
    meter.sums[SPEED] = 0.0
    state, outcome = half_cycle(state, scene, meter, None)
    _note(row, state, scene, notes)
    return state, outcome


@kernel
def advance(state, half, span, row, scene, notes):
    """Integrate `span` half cycles, noting every section point and, where metered, a row of the trace.

    Parameters
    ----------
    state : State
        After `half` half cycles.
    row : int
        Last row of the trace that is written; −1: not metered.

    Returns
    -------
    state : State
    half : int
        Half cycles since the start of the run.
    outcome : int
        ARRIVED, or how the run ended early.
    """
    counts = scene.counts
    counts[BUDGET] = counts[SEGMENTS] + _room(scene, span)
    counts[IDLE] = 0
    outcome = ARRIVED
    for i in range(span):
        if row >= 0:
            state, outcome = metered_half(state, row + 1 + i, scene, notes)
        else:
            state, outcome = half_cycle(state, scene, None, None)
        half += 1
        if outcome != ARRIVED:
            break
        coordinates(state, scene.particle, notes.ring[half % RING])
    return state, half, outcome


@kernel
def stretch_of(trace, first, last):
    """Totals over the half cycles of the rows first + 1 … last."""
    before = trace[first]
    after = trace[last]
    return Stretch(
        first,
        last,
        after[IMPACTS_SO_FAR] - before[IMPACTS_SO_FAR],
        after[_TOTALS] - before[_TOTALS],
        after[_TOTALS + 1] - before[_TOTALS + 1],
        after[_TOTALS + 2] - before[_TOTALS + 2],
        after[_TOTALS + 3] - before[_TOTALS + 3],
        after[_TOTALS + 4] - before[_TOTALS + 4],
        after[_TOTALS + 5] - before[_TOTALS + 5],
        before[STORED],
        after[STORED],
        trace[first + 1 : last + 1, HALF_SPEED].max(),
        trace[first + 1 : last + 1, HALF_PEAK].max(),
        trace[first + 1 : last + 1, HALF_RELATIVE_PEAK].max(),
    )


@kernel
def cycle_peaks(trace, rows, peaks):
    """Peaks per cycle that a motion and its mirror image share, which is the same motion half a cycle later.

    Parameters
    ----------
    trace : array
        Metered from row 1 on.
    rows : int
        Half cycles metered.
    peaks : array, shape (≥ rows // 2, 2)
        Filled with the mean of the peaks over the two windows of one cycle that begin in each cycle; of the last, which may
        lack the half cycle after it, over one.
    """
    for column in range(2):
        for i in range(rows // 2):
            first = trace[2 * i + 1, column]
            second = trace[2 * i + 2, column]
            peaks[i, column] = max(first, second)
            if 2 * i + 3 <= rows:
                peaks[i, column] = 0.5 * (peaks[i, column] + max(second, trace[2 * i + 3, column]))


@kernel
def losses_of_cycle(trace, cycle, which):
    """Loss by one mechanism (0 viscous, 1 friction, 2 impact) in one metered cycle."""
    column = _TOTALS + 1 + which
    return trace[2 * cycle + 2, column] - trace[2 * cycle, column]


@kernel
def impacts_of_cycle(trace, cycle):
    """Impacts in one metered cycle."""
    return trace[2 * cycle + 2, IMPACTS_SO_FAR] - trace[2 * cycle, IMPACTS_SO_FAR]
