"""Integration of a run over half cycles, and the data that are recorded during the run."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import filled, unit_matrix, zero_counts, zero_matrix
from damperlab.worker.solver.events import ARRIVED, BUDGET, COUNTS, IDLE, IMPACTS, SEGMENTS
from damperlab.worker.solver.excitation.excitation import phase_at
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.observe.meter import METERS, Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.solver.transition_log import Transitions, empty_transitions
from damperlab.worker.steady.response.energy import stored_energy
from damperlab.worker.steady.response.trace import (
    COLUMNS,
    IMPACTS_SO_FAR,
    STORED,
    clear_peaks,
    note_half,
)
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, coordinates
from damperlab.worker.steady.section.recurrence import LONGEST, PATH_COLUMNS, RING, note_point

EVENTS_PER_CYCLE = 100
"""Largest average number of events per cycle, over `max_cycles` cycles; a run with more events ends early."""

# Largest number of events in a cycle: a fixed number plus a number for each panel.
# With more events, impacts follow too fast to be resolved.
_EVENTS_AT_ONCE = 2000
_EVENTS_PER_WINDOW = 4
_WINDOWS_PER_EVENT = 128  # number of panels without events that cost about as much time as one event
_LOG_ROWS = 4096


class Notes(NamedTuple):
    """The recorded data of a run.

    Attributes
    ----------
    ring : array, shape (RING, SECTION_SIZE)
        The section points of the last half cycles.
    struck : array, shape (RING,)
        Number of impacts of the run up to each section point in `ring`.
    recurrences, recurrences_before : array, shape (LONGEST + 1,)
        Distance between the last section point and the section point one period earlier, for each period, at the
        current and at the previous examination.
    trace : array, shape (half cycles + 1, columns)
        One row per metered half cycle; row 0 is the start of metering.
    path : array, shape (half cycles + 1, PATH_COLUMNS), or None
        The section points of the metered half cycles, in the rows 1, 2, …; NaN if the particle rides on a wall.
        None without a particle and for a particle with friction, whose states cannot be made from section points.
    cycles : array, shape (2, cycles)
        Peaks of |u| and |v| of each metered cycle (`trace.cycle_peaks`).
    series : array, shape (cycles,)
        Buffer for other series per cycle.
    meter : Meter
        Sums over the metered half cycles.
    log : Transitions
        Transitions of one half cycle, from which the Jacobian is computed.
    monodromy : array, shape (SECTION_SIZE, SECTION_SIZE)
        Jacobian from the latest search for an orbit.
    candidate_point, candidate_departure : array, shape (SECTION_SIZE,)
        Section point of the candidate orbit, and the recorded difference between the run and this point.
    candidate_jacobian : array, shape (SECTION_SIZE, SECTION_SIZE)
        Jacobian of the candidate orbit.
    """

    ring: NDArray[np.float64]
    struck: NDArray[np.int64]
    recurrences: NDArray[np.float64]
    recurrences_before: NDArray[np.float64]
    trace: NDArray[np.float64]
    path: NDArray[np.float64] | None
    cycles: NDArray[np.float64]
    series: NDArray[np.float64]
    meter: Meter
    log: Transitions
    monodromy: NDArray[np.float64]
    candidate_point: NDArray[np.float64]
    candidate_departure: NDArray[np.float64]
    candidate_jacobian: NDArray[np.float64]


@kernel
def probe_of(scene: Scene) -> Scene:
    """Return a copy of a scene with separate counts, for the search for orbits."""
    return scene._replace(scratch=np.empty((4, TERMS)), counts=zero_counts(COUNTS))


@kernel
def begin_probe(probe: Scene, scene: Scene, halves: int) -> None:
    """Reset the counts of a probe for a search over `halves` half cycles, but copy the run's number of impacts."""
    for i in range(COUNTS):
        probe.counts[i] = 0
    probe.counts[IMPACTS] = scene.counts[IMPACTS]
    probe.counts[BUDGET] = _room(scene, halves)


@kernel
def _room(scene: Scene, halves: int) -> int:
    """Largest allowed number of events in `halves` half cycles."""
    room: int = halves * (_EVENTS_AT_ONCE // 2 + _EVENTS_PER_WINDOW * scene.base.windows)
    return room


@kernel
def make_notes(
    max_cycles: int, particle: Particle | None, energies: bool | None, acceleration: bool | None
) -> Notes:
    """Make empty notes of a run; `energies` and `acceleration` are passed to the meter (`observe.meter.Meter`)."""
    cycles = max_cycles + LONGEST
    path = None
    if particle is not None:
        if particle.friction is None:
            path = np.empty((2 * cycles + 1, PATH_COLUMNS))
    return Notes(
        zero_matrix(RING, SECTION_SIZE),
        zero_counts(RING),
        filled(LONGEST + 1, inf),
        filled(LONGEST + 1, inf),
        np.empty((2 * cycles + 1, COLUMNS)),
        path,
        np.empty((2, cycles)),
        np.empty(cycles),
        Meter(filled(METERS, 0.0), energies, acceleration),
        empty_transitions(_LOG_ROWS),
        unit_matrix(SECTION_SIZE),
        filled(SECTION_SIZE, 0.0),
        filled(SECTION_SIZE, 0.0),
        unit_matrix(SECTION_SIZE),
    )


@kernel
def work_done(scene: Scene, half: int) -> int:
    """Computational work of a run so far, in events.

    Work is counted, not timed, so that the speed of the machine does not affect the results.
    """
    done: int = scene.counts[SEGMENTS] + half * scene.base.windows // _WINDOWS_PER_EVENT
    return done


@kernel
def begin_trace(state: State, scene: Scene, notes: Notes) -> None:
    """Start metering, and write row 0 of the trace."""
    for i in range(METERS):
        notes.meter.sums[i] = 0.0
    for i in range(COLUMNS):
        notes.trace[0, i] = 0.0
    notes.trace[0, IMPACTS_SO_FAR] = scene.counts[IMPACTS]
    notes.trace[0, STORED] = stored_energy(state, phase_at(scene.base, 0).rate, scene.particle)


@kernel
def advance(
    state: State, half: int, halves: int, row: int, scene: Scene, notes: Notes
) -> tuple[State, int, int]:
    """Integrate half cycles. After each half cycle, record a section point and, if `row` ≥ 0, a trace row.

    Parameters
    ----------
    half, halves : int
        Number of half cycles from the start of the run to `state`, and number of half cycles to integrate.
    row : int
        Last written row of the trace; −1 to write no rows, as during the burn-in.

    Returns
    -------
    state : State
    half : int
        Number of half cycles since the start of the run.
    outcome : int
        ARRIVED, or the reason for an early end.
    """
    # unpacked once: in the loop, unpacking would take a third of the run time, as numba counts references
    trace, path, ring, struck = notes.trace, notes.path, notes.ring, notes.struck
    meter, counts = notes.meter, scene.counts
    counts[BUDGET] = counts[SEGMENTS] + _room(scene, halves)
    counts[IDLE] = 0
    outcome = ARRIVED
    for i in range(halves):
        if row >= 0:
            clear_peaks(meter)
            state, outcome = half_cycle_on_addresses(state, scene, meter, None)
            stored = stored_energy(state, phase_at(scene.base, 0).rate, scene.particle)
            note_half(trace[row + 1 + i], meter, counts[IMPACTS], stored)
        else:
            state, outcome = half_cycle_on_addresses(state, scene, None, None)
        half += 1
        if outcome != ARRIVED:
            break
        coordinates(state, scene.particle, ring[half % RING])
        struck[half % RING] = counts[IMPACTS]
        if row >= 0 and path is not None:
            note_point(ring, half % RING, state.riding, path, row + 1 + i)
    return state, half, outcome
