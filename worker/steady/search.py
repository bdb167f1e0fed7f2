"""The run towards the steady response. The run ends when the motion repeats, or when an orbit or the mean peak is
known.

The search for orbits uses copies of the state and separate counts, so the search does not change the run.
"""

from math import inf, pi
from typing import NamedTuple

from damperlab.studies.variables import Status
from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.events import ARRIVED, IMPACTS
from damperlab.worker.solver.excitation.excitation import has_force, largest_forcing
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import rubs
from damperlab.worker.solver.state import State
from damperlab.worker.steady.locked_by_friction import (
    creep_limit,
    dragging_limit,
    is_locked,
    slowing_limit,
    slows_down,
)
from damperlab.worker.steady.orbits.orbit import Orbit, SectionLook, no_orbit, repeated_orbit
from damperlab.worker.steady.orbits.orbit_watch import (
    Nearby,
    look_back,
    look_farther,
    look_nearby,
    nothing_nearby,
)
from damperlab.worker.steady.response.standard_errors import Estimate, estimate, grows
from damperlab.worker.steady.response.trace import IMPACTS_SO_FAR, cycle_peaks
from damperlab.worker.steady.run import EVENTS_PER_CYCLE, Notes, advance, begin_trace, work_done
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, active_size, coordinates
from damperlab.worker.steady.section.recurrence import RING, extent, note_recurrences
from damperlab.worker.steady.stopping_rules import (
    FEWEST_MEASURED,
    LARGEST_BURN_IN,
    Settings,
    burn_in_of,
    is_known,
    next_estimate,
)

_UNBOUNDED = int(Status.UNBOUNDED)
# Number of half cycles between two examinations of the section, doubled while metering.
# Even numbers ensure that whole cycles lie between two examinations.
# `_SHORT_CHUNK` is used if a half cycle has more than `_LONG_HALF` panels and so takes long.
_CHUNK = 32
_SHORT_CHUNK = 8
_LONG_HALF = 1000  # Number of panels above which a half cycle takes long.
# Added to the number of events allowed for all cycles, so that a short run is not cut off.
_SPARE_EVENTS = 20_000
# Value of `metered_halves` during the burn-in; `advance` and `look_farther` treat all negative numbers alike.
_NOT_METERED = -1
_LOCKED_LAG = 2  # Period of a locked mass [half cycles], which is the period of the excitation.
# Limits for a mass under a force while the particle slows down, relative to F₀/k.
# Until enough cycles are metered for a mean, the remaining displacement must be below `_AT_ONCE`.
# Afterwards, the limit is `tolerance` times the larger of `_SMALL` and the displacement in the locked state.
_AT_ONCE = 1e-6
_SMALL = 1e-2


class Found(NamedTuple):
    """Result of a run.

    Attributes
    ----------
    state : State
        State on the orbit; without an orbit, or for a locked state with a moving particle, the state at the end of the
        run.
    outcome : int
        ARRIVED, or the reason for an early end, for example peaks that grow without a visible bound.
    look : SectionLook
        Section data at the end of the run.
    orbit : Orbit
        The orbit to which the run tends; its `period_halves` is 0 if no repetition was found.
    mean : Estimate
        Estimate from the metered cycles; meaningful only if no repetition was found.
    known : bool
        Whether the response is known: an orbit was found, or the mean is known to the tolerance and no stable orbit was
        found near the run.
    way_left : float
        Bound on the distance from `orbit` to the final position of a locked mass while the particle still moves.
    """

    state: State
    outcome: int
    look: SectionLook
    orbit: Orbit
    mean: Estimate
    known: bool
    way_left: float


@kernel
def search(start: State, scene: Scene, probe: Scene, notes: Notes, settings: Settings) -> Found:
    """Run from a state at phase 0 until the steady response is known, or to the limit on cycles or events.

    `probe` is a copy of `scene` for the search for orbits; `notes` receive the data that are recorded during the run.
    """
    coordinates(start, scene.particle, notes.ring[0])
    chunk = _CHUNK if scene.base.windows <= _LONG_HALF else _SHORT_CHUNK
    last_half = 2 * settings.max_cycles
    work_allowed = EVENTS_PER_CYCLE * settings.max_cycles + _SPARE_EVENTS
    needed = burn_in_of(scene, settings)
    burn_in = needed // chunk * chunk
    # number of metered cycles that still belong to the burn-in, which ends between two examinations
    left_out = (needed - burn_in + 1) // 2
    state = start
    half = 0
    metered_halves = _NOT_METERED
    next_estimate_cycles = left_out + FEWEST_MEASURED  # metered
    nearby = nothing_nearby(start, _CHUNK)
    look = SectionLook(0, 1.0, SECTION_SIZE)
    mean = Estimate(0, 0, inf, inf, inf, False)
    locked, way_left = no_orbit(start), inf
    while half < last_half and work_done(scene, half) <= work_allowed:
        if metered_halves == _NOT_METERED:
            if half >= burn_in or work_done(scene, half) >= LARGEST_BURN_IN * work_allowed:
                metered_halves = 0
                begin_trace(state, scene, notes)
        halves = min(chunk if metered_halves == _NOT_METERED else 2 * chunk, last_half - half)
        state, half, outcome = advance(state, half, halves, metered_halves, scene, notes)
        if metered_halves != _NOT_METERED:
            metered_halves += halves
        look = SectionLook(half, extent(notes.ring, half), _taking_part(state, half, scene, notes))
        if outcome != ARRIVED:
            return Found(state, outcome, look, no_orbit(state), mean, False, 0.0)
        note_recurrences(notes.ring, half, notes.recurrences, notes.recurrences_before)
        tends_to, farthest = _locked_limit(state, half, scene, probe, notes)
        if tends_to.period_halves > 0:
            locked, way_left = tends_to, farthest
            # the limit is `_AT_ONCE` until enough cycles are metered for a mean
            waits = metered_halves < 2 * FEWEST_MEASURED
            if way_left <= (_AT_ONCE if waits else _allowed(locked, settings)):
                return Found(state, ARRIVED, look, locked, mean, True, way_left)
        orbit = repeated_orbit(state, look, halves, scene, probe, notes, settings)
        if orbit.period_halves == 0:
            nearby, orbit = look_nearby(nearby, state, look, burn_in, scene, probe, notes)
        if orbit.period_halves > 0:
            return Found(orbit.state, ARRIVED, look, orbit, mean, True, 0.0)
        nearby = look_farther(nearby, state, metered_halves, look, scene, probe, notes)
        if metered_halves >= 2 * next_estimate_cycles:
            mean = _mean_so_far(left_out, metered_halves, notes)
            if (
                is_known(mean, settings)
                and not nearby.rival
                and not _is_on_the_way(state, mean, scene, notes)
            ):
                if locked.period_halves > 0:
                    apart = mean.error + abs(mean.mean - abs(locked.state.v))
                    return Found(state, ARRIVED, look, locked, mean, True, min(way_left, apart))
                if not slows_down(scene):
                    nearby = look_back(nearby, state, metered_halves, look, scene, probe, notes)
                    if not nearby.rival:
                        return Found(state, ARRIVED, look, no_orbit(state), mean, True, 0.0)
            next_estimate_cycles = next_estimate(mean, settings)
    if locked.period_halves > 0:
        known = way_left <= _allowed(locked, settings)
        return Found(state, ARRIVED, look, locked, mean, known, way_left)
    return _end_of_search(state, look, left_out, metered_halves, nearby, scene, probe, notes, settings)


@kernel
def _locked_limit(state: State, half: int, scene: Scene, probe: Scene, notes: Notes) -> tuple[Orbit, float]:
    """Return the locked state of the run, or the locked state to which the run tends, and a bound on the remaining
    displacement.

    The period of the returned orbit is 0 if no locked state was found.
    """
    if scene.particle is not None and scene.particle.friction is not None:
        if scene.friction is not None and not has_force(scene.base):
            limit, apart = dragging_limit(state, scene.friction, scene, probe)
            if apart < inf:
                return Orbit(limit, _LOCKED_LAG, apart), 0.0
        return no_orbit(state), inf
    if scene.friction is not None:
        if scene.counts[IMPACTS] == 0:
            forcing = largest_forcing(scene.base)
            limit, creeps = creep_limit(state, scene.friction, scene)
            if creeps or is_locked(state, scene.friction, forcing, notes.ring, half):
                return Orbit(limit, _LOCKED_LAG, 0.0), 0.0
        if scene.particle is not None and has_force(scene.base):
            limit, way_left = slowing_limit(state, scene.friction, scene.particle, scene)
            if way_left < inf:
                return Orbit(limit, _LOCKED_LAG, 0.0), way_left
    return no_orbit(state), inf


@kernel
def _allowed(locked: Orbit, settings: Settings) -> float:
    """Distance from a locked state within which the position of the mass is considered known."""
    return settings.tolerance * max(abs(locked.state.v), _SMALL)


@kernel
def _mean_so_far(left_out: int, metered_halves: int, notes: Notes) -> Estimate:
    """Mean peak of the metered cycles and its error, without the cycles of a transient."""
    cycle_peaks(notes.trace, metered_halves, notes.cycles)
    cycles = metered_halves // 2
    mean: Estimate = estimate(notes.cycles[0], min(left_out, cycles - 1), cycles)
    return mean


@inlined
def _taking_part(state: State, half: int, scene: Scene, notes: Notes) -> int:
    """Number of leading section coordinates in which an orbit of the run closes.

    The position of a particle with friction matters only if the particle has struck a wall in the stored half cycles.
    """
    if rubs(scene.particle):
        before = notes.struck[(half - min(half, RING - 1)) % RING]
        return SECTION_SIZE if scene.counts[IMPACTS] > before else SECTION_SIZE - 1
    return active_size(state, scene.particle, scene.counts)


@kernel
def _is_on_the_way(state: State, mean: Estimate, scene: Scene, notes: Notes) -> bool:
    """Whether an impact is still to come: the particle moves, but met no wall in the cycles that the mean covers."""
    if scene.particle is not None:
        before = notes.trace[2 * mean.first, IMPACTS_SO_FAR]
        after = notes.trace[2 * mean.last, IMPACTS_SO_FAR]
        on_the_way: bool = state.p_rate != 0.0 and after == before
        return on_the_way
    return False


@kernel
def _has_no_bound(first: int, last: int, scene: Scene, notes: Notes) -> bool:
    """Whether the peaks of the metered cycles grow without a visible bound.

    At resonance without viscous damping and without impacts, a cycle of amplitude A gains the energy π A and
    loses 4 γ_F A to friction. So growth never ends if γ_F < π/4. In all other cases, the result follows from
    the trend of the peaks.
    """
    undamped = scene.base.two_zeta == 0.0 and scene.base.frequency_ratio == 1.0 and scene.counts[IMPACTS] == 0
    undamped = undamped and not rubs(scene.particle)
    if scene.friction is not None:
        undamped = undamped and scene.friction < 0.25 * pi
    peaks = notes.cycles[0]
    if undamped:
        without_end: bool = peaks[last - 1] > peaks[first]
        return without_end
    still_grows: bool = grows(peaks, first, last)
    return still_grows


@kernel
def _end_of_search(
    state: State,
    look: SectionLook,
    left_out: int,
    metered_halves: int,
    nearby: Nearby,
    scene: Scene,
    probe: Scene,
    notes: Notes,
    settings: Settings,
) -> Found:
    """Result of a run that has reached its limit on cycles or events: the mean over the metered cycles.

    If no complete cycle is metered, one further cycle is integrated. If the peaks grow to the end of the run,
    the outcome is UNBOUNDED.
    """
    if metered_halves == _NOT_METERED:  # the limit was reached during the burn-in
        metered_halves = 0
        begin_trace(state, scene, notes)
    if metered_halves < 2:
        state, _, outcome = advance(state, look.half, 2, metered_halves, scene, notes)
        metered_halves += 2
        look = look._replace(half=look.half + 2)
        if outcome != ARRIVED:
            mean = Estimate(0, 0, inf, inf, inf, False)
            return Found(state, outcome, look, no_orbit(state), mean, False, 0.0)
    mean = _mean_so_far(left_out, metered_halves, notes)
    cycles = metered_halves // 2
    if _has_no_bound(min(left_out, cycles - 1), cycles, scene, notes):
        return Found(state, _UNBOUNDED, look, no_orbit(state), mean, False, 0.0)
    known = (
        is_known(mean, settings) and not _is_on_the_way(state, mean, scene, notes) and not slows_down(scene)
    )
    if known:
        known = not look_back(nearby, state, metered_halves, look, scene, probe, notes).rival
    return Found(state, ARRIVED, look, no_orbit(state), mean, known, 0.0)
