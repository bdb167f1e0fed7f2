"""The run towards the steady response: on until it repeats, until the orbit it tends to is known, or until its mean is.

The run itself is a plain integration. What looks for orbits works beside it, on copies of its state and with counts of its
own, so the run is the same whatever is looked for.
"""

from math import inf
from typing import NamedTuple

from damperlab.worker.jit import kernel
from damperlab.worker.solver.state import ARRIVED, IMPACTS, State
from damperlab.worker.steady.candidate import (
    closing_in,
    is_beside_stable_orbit,
    no_candidate,
    stable_orbit_nearby,
)
from damperlab.worker.steady.coordinates import active_size, coordinates
from damperlab.worker.steady.orbit import Look, Orbit, repeated_orbit
from damperlab.worker.steady.run import EVENTS_PER_CYCLE, advance, begin_trace, work_done
from damperlab.worker.steady.section import extent, note_recurrences
from damperlab.worker.steady.statistics import Estimate, estimate
from damperlab.worker.steady.stopping import (
    FEWEST_MEASURED,
    LARGEST_BURN_IN,
    burn_in_of,
    creep_limit,
    is_known,
    is_locked,
    next_look,
)
from damperlab.worker.steady.trace import cycle_peaks
from damperlab.worker.steady.variational import SIZE

# Half cycles between looks at the section; even, so that whole cycles lie between. Fewer where a half cycle takes long.
_CHUNK = 32
_SHORT_CHUNK = 8
_LONG_HALF = 1000  # windows
_SPARE_EVENTS = 20_000
# Half cycles spent on looking for orbits nearby, beside those of the run: in its burn-in, and once it is metered.
_MOST_BESIDE = 0.1
_MOST_BESIDE_METERED = 0.05
_FAR_EVERY = 128  # half cycles between tries at a stable orbit farther off, once the run is metered


class Found(NamedTuple):
    """What a run came to.

    Attributes
    ----------
    state : State
        On the orbit, or where the run stopped.
    outcome : int
        ARRIVED, or how the run ended early.
    look : Look
        At the end of the run.
    orbit : Orbit
        That the run tends to; its `lag` is 0 where the response was not found to repeat.
    mean : Estimate
        Of the metered cycles; meaningful only where the response does not repeat.
    known : bool
        Whether the response is known: an orbit was found, or the mean is known to the tolerance and no stable orbit is
        known that the run may still come to.
    """

    state: State
    outcome: int
    look: Look
    orbit: Orbit
    mean: Estimate
    known: bool


@kernel
def search(start, scene, probe, friction, particle, notes, settings):
    """Run from a state until the steady response is known, or to the limit on cycles or events.

    Parameters
    ----------
    start : State
        At phase 0.
    scene, probe : Scene
        What the run is integrated in, and the same for what looks for orbits beside it.
    friction, particle
        Those of the scene, once more by themselves: absent, they are None.
    notes : Notes
        Filled on the way.
    settings : Settings
        When to stop.

    Returns
    -------
    Found
    """
    ring = notes.ring
    state = start
    coordinates(state, particle, ring[0])
    chunk = _CHUNK if scene.base.windows <= _LONG_HALF else _SHORT_CHUNK
    most = 2 * settings.max_cycles
    most_work = EVENTS_PER_CYCLE * settings.max_cycles + _SPARE_EVENTS
    burn_in = burn_in_of(scene.base, settings) // chunk * chunk
    outcome = ARRIVED
    half = 0
    metered = -1  # half cycles
    look_at = FEWEST_MEASURED
    next_try = _CHUNK
    none = Orbit(state, 0, inf)
    candidate = no_candidate(state)
    rival = False  # a stable orbit is known that the run has not come to
    beside = 0  # half cycles spent on looking for orbits
    look = Look(0, 1.0, SIZE)
    mean = Estimate(0, 0, inf, inf, inf, False)
    while half < most and work_done(scene, half) <= most_work:
        if metered < 0 and (half >= burn_in or work_done(scene, half) >= LARGEST_BURN_IN * most_work):
            metered = 0
            begin_trace(state, scene, notes)
        span = min(chunk if metered < 0 else 2 * chunk, most - half)
        state, half, outcome = advance(state, half, span, metered, scene, notes)
        look = Look(half, extent(ring, half), active_size(state, particle, scene.counts))
        if outcome != ARRIVED:
            return Found(state, outcome, look, none, mean, False)
        if metered >= 0:
            metered += span
        if friction is not None:
            if scene.counts[IMPACTS] == 0:
                limit, crept = creep_limit(state, friction, scene.base.frequency_ratio)
                if crept or is_locked(state, friction, scene.base.frequency_ratio, ring, half):
                    return Found(limit, ARRIVED, look, Orbit(limit, 2, 0.0), mean, True)
        note_recurrences(ring, half, notes.apart, notes.before)
        orbit = repeated_orbit(state, look, span, scene, probe, particle, notes, settings)
        if orbit.lag > 0:
            return Found(orbit.state, ARRIVED, look, orbit, mean, True)
        if candidate.orbit.lag > 0:
            candidate, arrives = closing_in(candidate, look, scene, probe, particle, notes)
            if arrives:
                return Found(candidate.orbit.state, ARRIVED, look, candidate.orbit, mean, True)
            if candidate.orbit.lag == 0:
                next_try = half + half // 2
                rival = True
        elif half >= next_try:
            next_try = half + _CHUNK
            spare = _halves_to_spare(half, burn_in) - beside
            candidate, arrives, halves = stable_orbit_nearby(
                state, look, spare, scene, probe, particle, notes
            )
            beside += halves
            if arrives:
                return Found(candidate.orbit.state, ARRIVED, look, candidate.orbit, mean, True)
        if metered >= 0 and metered % _FAR_EVERY == 0 and not rival:
            if scene.counts[IMPACTS] > 0:
                lag = 1 + metered // _FAR_EVERY % 2
                # bounded by how seldom it is done: taken from the others' share, it would leave them nothing
                rival, _ = is_beside_stable_orbit(state, lag, look, scene, probe, particle, notes)
        if metered >= 2 * look_at:
            cycle_peaks(notes.trace, metered, notes.cycles)
            mean = estimate(notes.cycles[0], 0, metered // 2)
            if is_known(mean, settings) and not rival:
                return Found(state, ARRIVED, look, none, mean, True)
            look_at = next_look(mean, settings)
    if metered < 0:  # nothing was left after the burn-in
        metered = 0
        begin_trace(state, scene, notes)
    if metered < 2:
        state, half, outcome = advance(state, half, 2, metered, scene, notes)
        metered += 2
        if outcome != ARRIVED:
            return Found(state, outcome, look, none, mean, False)
    cycle_peaks(notes.trace, metered, notes.cycles)
    mean = estimate(notes.cycles[0], 0, metered // 2)
    return Found(state, ARRIVED, look, none, mean, is_known(mean, settings) and not rival)


@kernel
def _halves_to_spare(half, burn_in):
    """Half cycles that may be spent on looking for orbits beside a run of so many."""
    return _CHUNK + _MOST_BESIDE * min(half, burn_in) + _MOST_BESIDE_METERED * max(half - burn_in, 0)
