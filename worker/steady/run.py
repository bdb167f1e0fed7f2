"""A run of whole half cycles: what it marches in, what it remembers, and how it goes on."""

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.contact.media import make_loaded
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.propagator import make_base, make_medium
from damperlab.worker.solver.motion.taylor import TERMS
from damperlab.worker.solver.state import ARRIVED, BUDGET, COUNTS, METERS, PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.transitions import Transitions, empty_transitions
from damperlab.worker.steady.orbit import coordinates
from damperlab.worker.steady.section import LONGEST, RING
from damperlab.worker.steady.variational import SIZE

_SEGMENTS_PER_CYCLE = 2000  # budget: beyond it impacts follow each other too fast to resolve
_LOG_ROWS = 4096


class Scene(NamedTuple):
    """What every half cycle is marched in, as the arguments of `integrate.half_cycle`; the absent is None.

    Passed on as a whole, taken apart where it is used: only a direct argument that is None is dropped by the compiler.
    """

    base: Any
    free: Any
    loaded: Any
    friction: Any
    particle: Any
    work: NDArray[np.float64]
    counts: NDArray[np.int64]


class Notes(NamedTuple):
    """What a run remembers.

    Attributes
    ----------
    ring : array, shape (RING, SIZE)
        The last section points.
    before : array, shape (LONGEST + 1,)
        The recurrence of each period at the last look.
    peaks : array, shape (cycles, 2)
        Largest |u| and |v| of the metered cycles.
    meter : Meter
        Sums over the metered cycles.
    log : Transitions
        The transitions of one half cycle, for its Jacobian.
    monodromy : array, shape (SIZE, SIZE)
        Jacobian of the last orbit.
    orbit, departure : array, shape (SIZE,)
        Section point of the orbit that waits to be confirmed, and how far from it the run was then.
    """

    ring: NDArray[np.float64]
    before: NDArray[np.float64]
    peaks: NDArray[np.float64]
    meter: Meter
    log: Transitions
    monodromy: NDArray[np.float64]
    orbit: NDArray[np.float64]
    departure: NDArray[np.float64]


@kernel
def make_scene(damping_ratio, frequency_ratio, friction, particle, max_cycles, energies):
    """What one design point is marched in, with room for the events of `max_cycles`."""
    base = make_base(damping_ratio, frequency_ratio, energies)
    free = make_medium(base, 1.0, energies)
    loaded = None
    if particle is not None:
        loaded = make_loaded(base, particle, particle.wall, energies)
    counts = np.zeros(COUNTS, np.int64)
    counts[BUDGET] = _SEGMENTS_PER_CYCLE * (max_cycles + 50)
    return Scene(base, free, loaded, friction, particle, np.empty((4, TERMS)), counts)


@kernel
def make_notes(max_cycles, energies):
    """Empty notes of a run."""
    return Notes(
        np.zeros((RING, SIZE)),
        np.full(LONGEST + 1, inf),
        np.empty((max_cycles + LONGEST, 2)),
        Meter(np.zeros(METERS), energies),
        empty_transitions(_LOG_ROWS),
        np.eye(SIZE),
        np.zeros(SIZE),
        np.zeros(SIZE),
    )


@kernel
def advance(state, half, span, metered, scene, notes):
    """March `span` half cycles, noting every section point and, where metered, energies and peaks.

    Parameters
    ----------
    state : State
        After `half` half cycles; metering starts and ends with whole cycles.

    Returns
    -------
    state : State
    half : int
        Half cycles since the start of the run.
    outcome : int
        ARRIVED, or how the march ended early.
    """
    base, free, loaded, friction, particle, work, counts = scene
    ring, peaks, meter = notes.ring, notes.peaks, notes.meter
    sums = meter.sums
    outcome = ARRIVED
    for _ in range(span):
        if metered:
            if half % 2 == 0:
                sums[PEAK] = 0.0
                sums[RELATIVE_PEAK] = 0.0
            state, outcome = half_cycle(
                state, base, free, loaded, friction, particle, work, counts, meter, None
            )
            peaks[half // 2, 0] = sums[PEAK]
            peaks[half // 2, 1] = sums[RELATIVE_PEAK]
        else:
            state, outcome = half_cycle(
                state, base, free, loaded, friction, particle, work, counts, None, None
            )
        half += 1
        if outcome != ARRIVED:
            break
        coordinates(state, particle, ring[half % RING])
    return state, half, outcome


@kernel
def metered_cycle(state, scene, meter):
    """One excitation cycle with the meter on; its peaks are those of this cycle alone."""
    base, free, loaded, friction, particle, work, counts = scene
    meter.sums[PEAK] = 0.0
    meter.sums[RELATIVE_PEAK] = 0.0
    outcome = ARRIVED
    for _ in range(2):
        state, outcome = half_cycle(state, base, free, loaded, friction, particle, work, counts, meter, None)
        if outcome != ARRIVED:
            break
    return state, outcome
