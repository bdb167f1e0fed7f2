"""Search for stable orbits near a run."""

from math import sqrt
from typing import NamedTuple

from damperlab.worker.jit import kernel
from damperlab.worker.solver.events import IMPACTS
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.steady.orbits.candidate import (
    Candidate,
    closing_in,
    is_beside_stable_orbit,
    no_candidate,
    stable_orbit_nearby,
)
from damperlab.worker.steady.orbits.orbit import Orbit, SectionLook, no_orbit
from damperlab.worker.steady.run import Notes
from damperlab.worker.steady.section.coordinates import flying_at
from damperlab.worker.steady.section.recurrence import SQUARED_EXTENT, closest_recurrences

_BETWEEN_TRIES = 32  # Number of half cycles of the run between two searches for a stable orbit.
# Largest cost of the search for nearby orbits, as a fraction of the half cycles of the run.
# The first fraction is for the burn-in, the second for the metered half cycles.
_SHARE_IN_BURN_IN = 0.1
_SHARE_METERED = 0.05
# Number of metered half cycles between two searches for a more distant stable orbit, and the periods tried in turn.
# Short periods are tried more often, because most chaotic transients end on orbits of short period.
_FAR_EVERY = 64
_FAR_PERIODS = (1, 2, 3, 1, 2, 4)
# Relative recurrence above which the run is too far from repeating for this search.
_FAR_RECURRENCE = 0.75
# Longest period of the search along the metered run, and largest sum of the periods of all starts with one period.
# With the period p, Newton's method is started if the relative recurrence is at most `_REPEATS`/p: the longer the
# period, the more a start costs, and the nearer to the orbit the start must be.
_LONGEST_BACK = 16
_HALVES_BACK = 12
_REPEATS = 0.7


class Nearby(NamedTuple):
    """Results of the search for stable orbits near a run.

    Attributes
    ----------
    candidate : Candidate
        The candidate to be confirmed; the period of its orbit is 0 if there is no candidate.
    next_try : int
        Half cycle of the run from which the search for another orbit may start.
    halves_spent : int
        Number of half cycles spent on searching.
    rival : bool
        Whether a known stable orbit exists that the run has not reached.
    """

    candidate: Candidate
    next_try: int
    halves_spent: int
    rival: bool


@kernel
def nothing_nearby(state: State, first_try: int) -> Nearby:
    """Return the initial results, before the first search."""
    return Nearby(no_candidate(state), first_try, 0, False)


@kernel
def look_nearby(
    nearby: Nearby, state: State, look: SectionLook, burn_in: int, scene: Scene, probe: Scene, notes: Notes
) -> tuple[Nearby, Orbit]:
    """Test the pending candidate or, if there is none, search for a new candidate.

    Return the results, and the orbit to which the run tends. If no orbit is confirmed, the period of the
    returned orbit is 0.
    """
    candidate, next_try, halves_spent, rival = nearby
    confirmed = False
    waits = candidate.orbit.period_halves > 0
    # without a particle no candidate is pending: a stable orbit attracts every motion (`candidate.attracts_all`)
    if scene.particle is not None:
        if waits:
            candidate, confirmed = closing_in(candidate, look, scene, probe, notes)
            if candidate.orbit.period_halves == 0:
                next_try = look.half + look.half // 2
                rival = True
    if not waits and look.half >= next_try:
        next_try = look.half + _BETWEEN_TRIES
        spare = _halves_to_spare(look.half, burn_in) - halves_spent
        candidate, confirmed, halves = stable_orbit_nearby(state, look, spare, scene, probe, notes)
        halves_spent += halves
    orbit = candidate.orbit if confirmed else no_orbit(state)
    return Nearby(candidate, next_try, halves_spent, rival), orbit


@kernel
def look_farther(
    nearby: Nearby,
    state: State,
    metered_halves: int,
    look: SectionLook,
    scene: Scene,
    probe: Scene,
    notes: Notes,
) -> Nearby:
    """Search for a more distant stable orbit, once in `_FAR_EVERY` metered half cycles.

    A run that does not repeat may end on a distant stable orbit. The half cycles of this
    search are not added to `halves_spent`, whose upper limit applies only to the frequent searches near the run.
    """
    if metered_halves < 0 or metered_halves % _FAR_EVERY != 0 or nearby.rival:
        return nearby
    if scene.particle is not None:
        if scene.counts[IMPACTS] > 0:
            period_halves = _FAR_PERIODS[metered_halves // _FAR_EVERY % len(_FAR_PERIODS)]
            if notes.recurrences[period_halves] <= _FAR_RECURRENCE * look.scale:
                rival = is_beside_stable_orbit(state, period_halves, look, scene, probe, notes)
                return nearby._replace(rival=rival)
    return nearby


@kernel
def look_back(
    nearby: Nearby,
    state: State,
    metered_halves: int,
    look: SectionLook,
    scene: Scene,
    probe: Scene,
    notes: Notes,
) -> Nearby:
    """Search for a stable orbit along the metered run, before the mean of the run is accepted.

    A chaotic transient that ends on a stable orbit almost repeats now and then with the period of this orbit. So
    Newton's method starts where the run repeats best over two periods, in each of several equal parts of the run.
    The search is omitted if the particle has friction in its cavity, because its states cannot be computed from
    section points.
    """
    if scene.particle is not None and notes.path is not None:
        if scene.counts[IMPACTS] > 0 and not nearby.rival:
            for period_halves in range(1, _LONGEST_BACK + 1):
                parts = max(_HALVES_BACK // period_halves, 1)
                farthest = _REPEATS / period_halves
                for row in closest_recurrences(notes.path, metered_halves, period_halves, parts, farthest):
                    if row > 0:
                        there = look._replace(scale=sqrt(notes.path[row, SQUARED_EXTENT]))
                        start, possible = flying_at(notes.path[row], state, scene.friction, scene.particle)
                        if possible and is_beside_stable_orbit(
                            start, period_halves, there, scene, probe, notes
                        ):
                            return nearby._replace(rival=True)
    return nearby


@kernel
def _halves_to_spare(half: int, burn_in: int) -> float:
    """Largest total of half cycles that all searches may spend until the run reaches the half cycle `half`."""
    return _BETWEEN_TRIES + _SHARE_IN_BURN_IN * min(half, burn_in) + _SHARE_METERED * max(half - burn_in, 0)
