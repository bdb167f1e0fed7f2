"""Stable orbits near a run, as candidates for its response.

An orbit is accepted as the response only if the run approaches the orbit as the linearisation of the orbit predicts.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.array_loops import copy_matrix, filled
from damperlab.worker.solver.events import ARRIVED, IMPACTS
from damperlab.worker.solver.integrate import half_cycle_on_addresses
from damperlab.worker.solver.observe.meter import METERS, PEAK, Meter
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State
from damperlab.worker.steady.orbits.newton import norm
from damperlab.worker.steady.orbits.orbit import Orbit, SectionLook, newton_orbit, no_orbit
from damperlab.worker.steady.run import Notes, begin_probe
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, coordinates
from damperlab.worker.steady.section.recurrence import LONGEST, RING, near_period
from damperlab.worker.steady.stability.multipliers import spectral_radius

Array = NDArray[np.float64]

# The following values are chosen, not derived; `accuracy.steady_answers` measures the error rate of the answers.
_TRIAL_PERIODS = 4  # Newton's method is started only if at least this number of periods may be integrated.
# Largest multiplier of an orbit that attracts; the margin covers the rounding of a multiplier of one.
_ATTRACTS = 1.0 - 1e-9
_REACH = 0.1  # Largest relative distance from the run at which a stable orbit becomes a candidate.
_FAR_REACH = 0.5  # Longest relative Newton step in the search for a more distant orbit.
_SURELY_REPELS = 10.0  # Multiplier near an orbit above which the orbit itself does not attract.
# A candidate is confirmed when the run's distance from the orbit has fallen to `_CLOSED_IN` times the first distance.
# `_CLOSED_IN_SLOWLY` is sufficient if the run has followed the linearisation for `_LONG` half cycles.
# Within this time, a run that only passes the orbit would have left the orbit.
_CLOSED_IN = 0.3
_CLOSED_IN_SLOWLY = 0.7
_LONG = 256
# Relative distance at which a run has reached an orbit, whatever the first distance.
_AT_THE_ORBIT = 1e-8
# Limits for comparing one stretch of the run with the linearisation, relative to the distance from the orbit.
_OFF_PREDICTION = 0.25  # A run leaves the orbit if the deviation from the prediction exceeds this fraction.
_NEARER = 0.7  # A run approaches the orbit if the distance falls to this fraction in the stretch.
_NO_PREDICTION = 1e-4  # No prediction is needed if the distance falls to this fraction in the stretch.
_ROUNDING = 1e-10  # Relative distance from the orbit that rounding alone can cause.

LEAVES, FOLLOWS, APPROACHES = range(3)
"""Behaviours of a run near an orbit."""


class Candidate(NamedTuple):
    """A stable orbit whose confirmation by the run is pending.

    Attributes
    ----------
    orbit : Orbit
    met : int
        Half cycle of the run at which the orbit was found.
    since : int
        Half cycle at which the distance of the run from the orbit was last recorded.
    share : float
        Distance of the run from the orbit at `since`, as a fraction of the first distance.
    struck : int
        Number of impacts of the run until `since`.
    """

    orbit: Orbit
    met: int
    since: int
    share: float
    struck: int


@kernel
def no_candidate(state: State) -> Candidate:
    """Return a `Candidate` without an orbit."""
    return Candidate(no_orbit(state), 0, 0, 1.0, 0)


@kernel
def stable_orbit_nearby(
    state: State, look: SectionLook, spare: float, scene: Scene, probe: Scene, notes: Notes
) -> tuple[Candidate, bool, int]:
    """Search for a stable orbit within reach of the run.

    Parameters
    ----------
    spare : float
        Largest number of half cycles that may be integrated. Newton's method is not started if it might need
        more half cycles.

    Returns
    -------
    candidate : Candidate
        The orbit to be confirmed; the period of the orbit is 0 if no orbit was found.
    confirmed : bool
        True if no further confirmation is needed, because the run must tend to the orbit.
    halves : int
        Number of half cycles integrated.
    """
    particle = scene.particle
    nothing = no_candidate(state)
    period_halves = near_period(notes.recurrences, min(LONGEST, look.half // 2), look.scale)
    if period_halves == 0 or _TRIAL_PERIODS * period_halves > spare:
        return nothing, False, 0
    reach = inf if particle is None else 2.0 * _REACH * look.scale
    orbit, found, halves = newton_orbit(state, period_halves, reach, inf, look, scene, probe, notes)
    if not found or not spectral_radius(notes.monodromy, look.size) < _ATTRACTS:
        return nothing, False, halves
    point = notes.ring[look.half % RING]
    coordinates(orbit.state, particle, notes.candidate_point)
    for i in range(SECTION_SIZE):
        notes.candidate_departure[i] = point[i] - notes.candidate_point[i]
        if particle is not None:
            if abs(notes.candidate_departure[i]) > _REACH * look.scale:
                return nothing, False, halves
    copy_matrix(notes.monodromy, notes.candidate_jacobian)
    confirmed = attracts_all(orbit, point, scene, probe, notes)
    return Candidate(orbit, look.half, look.half, 1.0, scene.counts[IMPACTS]), confirmed, halves


@kernel
def is_beside_stable_orbit(
    state: State, period_halves: int, look: SectionLook, scene: Scene, probe: Scene, notes: Notes
) -> bool:
    """Whether Newton's method from the present state leads to a stable orbit of this period.

    Near a stable orbit, a run that does not repeat may be a transient that ends on this orbit.
    """
    reach = _FAR_REACH * look.scale
    _, found, _ = newton_orbit(state, period_halves, reach, _SURELY_REPELS, look, scene, probe, notes)
    attracts: bool = spectral_radius(notes.monodromy, look.size) < _ATTRACTS
    return found and attracts


@kernel
def attracts_all(orbit: Orbit, point: Array, scene: Scene, probe: Scene, notes: Notes) -> bool:
    """Whether the run must tend to a stable orbit.

    Without impacts v'' + 2ζv' + v + γ Sgn(v') = f is monotone: the distance √(Δv² + Δw²) of any two motions never
    grows. So a stable periodic motion attracts all other motions, provided that the particle meets no wall on the way.
    """
    particle = scene.particle
    if particle is not None:
        if scene.counts[IMPACTS] > 0 or point[3] != 0.0:
            return False
        begin_probe(probe, scene, 2)
        far = sqrt((point[0] - notes.candidate_point[0]) ** 2 + (point[1] - notes.candidate_point[1]) ** 2)
        meter = Meter(filled(METERS, 0.0), notes.meter.energies, notes.meter.acceleration)
        sums = on_addresses(meter)
        state = orbit.state
        for _ in range(2):
            state, outcome = half_cycle_on_addresses(state, probe, sums, None)
            if outcome != ARRIVED:
                return False
        clear: bool = meter.sums[PEAK] + far + abs(point[2]) < particle.clearance_ratio
        return clear
    return True


@kernel
def closing_in(
    candidate: Candidate, look: SectionLook, scene: Scene, probe: Scene, notes: Notes
) -> tuple[Candidate, bool]:
    """Update a candidate after a further stretch of the run, and return whether the candidate is confirmed.

    If the run leaves the orbit, the period of the returned candidate is 0.

    The run must approach the orbit as the linearisation predicts, stretch after stretch, until the distance
    has fallen to `_CLOSED_IN` times the first distance. After `_LONG` half cycles, a fall to
    `_CLOSED_IN_SLOWLY` times the first distance is sufficient. The test over many half cycles is necessary,
    because a run may seem for a while to approach an orbit whose basin ends close by. If the
    number of impacts in a stretch differs from that of the orbit, the stretch is no confirmation, because the
    linearisation does not apply to it.
    Without impacts, the candidate is dropped unless the orbit attracts all motions (`attracts_all`).
    """
    orbit = candidate.orbit
    nothing = no_candidate(orbit.state)
    periods = (look.half - candidate.since) // orbit.period_halves
    at = candidate.since + periods * orbit.period_halves
    point = notes.ring[at % RING]
    verdict = _follows(point, periods, look, notes)
    if verdict == LEAVES:
        return nothing, False
    if verdict != APPROACHES:
        return candidate, False
    if scene.counts[IMPACTS] == 0:
        confirmed = attracts_all(orbit, point, scene, probe, notes)
        return (candidate, True) if confirmed else (nothing, False)
    first = 0.0
    now = 0.0
    for i in range(look.size):
        first += notes.candidate_departure[i] ** 2
        notes.candidate_departure[i] = point[i] - notes.candidate_point[i]
        now += notes.candidate_departure[i] ** 2
    share = candidate.share * (sqrt(now / first) if first > 0.0 else 0.0)
    enough = _CLOSED_IN_SLOWLY if look.half - candidate.met >= _LONG else _CLOSED_IN
    confirmed = share <= enough or sqrt(now) <= _AT_THE_ORBIT * look.scale
    struck = notes.struck[at % RING]
    if confirmed:
        confirmed = struck - candidate.struck == periods * _impacts_of(orbit, scene, probe)
    return candidate._replace(since=at, share=share, struck=struck), confirmed


@kernel
def _impacts_of(orbit: Orbit, scene: Scene, probe: Scene) -> int:
    """Number of impacts in one period of an orbit; −1 if the integration ends early."""
    begin_probe(probe, scene, orbit.period_halves)
    before: int = probe.counts[IMPACTS]
    state = orbit.state
    for _ in range(orbit.period_halves):
        state, outcome = half_cycle_on_addresses(state, probe, None, None)
        if outcome != ARRIVED:
            return -1
    return int(probe.counts[IMPACTS]) - before


@kernel
def _follows(point: Array, periods: int, look: SectionLook, notes: Notes) -> int:
    """Compare the run's deviation from the orbit with the linearisation, over the last `periods` periods.

    Parameters
    ----------
    point : array, shape (SECTION_SIZE,)
        Present section point of the run.

    Returns
    -------
    verdict : int
        LEAVES, FOLLOWS (as predicted, but hardly nearer than before) or APPROACHES. FOLLOWS is no proof of an approach:
        if an orbit has a multiplier near the unit circle, a run near the orbit may wander permanently and seem for a
        while to settle.
    """
    predicted = notes.candidate_departure.copy()
    for _ in range(periods):
        moved = filled(SECTION_SIZE, 0.0)
        for i in range(look.size):
            for j in range(look.size):
                moved[i] += notes.candidate_jacobian[i, j] * predicted[j]
        predicted = moved
    off = 0.0
    now = 0.0
    for i in range(look.size):
        gone = point[i] - notes.candidate_point[i]
        now += gone * gone
        off += (gone - predicted[i]) ** 2
    now = sqrt(now)
    first = norm(notes.candidate_departure, look.size)
    if now <= _NO_PREDICTION * first:
        return APPROACHES
    if sqrt(off) > _OFF_PREDICTION * now + _ROUNDING * look.scale:
        return LEAVES
    return APPROACHES if now <= _NEARER * first or now <= _ROUNDING * look.scale else FOLLOWS
