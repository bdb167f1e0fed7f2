"""The run towards the steady response: on until it repeats, until the orbit it tends to is known, or until its mean is.

The run itself is a plain integration. What looks for orbits works beside it, on copies of its state and with counts of its
own, so the run is the same whatever is looked for.
"""

from math import inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.state import ARRIVED, IMPACTS, METERS, PEAK, Meter, State
from damperlab.worker.steady.eigenvalues import spectral_radius
from damperlab.worker.steady.orbit import (
    APPROACHES,
    LEAVES,
    active_size,
    around,
    coordinates,
    find_orbit,
    follows,
)
from damperlab.worker.steady.run import (
    EVENTS_PER_CYCLE,
    advance,
    begin_beside,
    begin_trace,
    cycle_peaks,
    work_done,
)
from damperlab.worker.steady.section import (
    LONGEST,
    RING,
    extent,
    near_period,
    recurrence,
    settled_period,
    stays_closed,
)
from damperlab.worker.steady.statistics import Estimate, estimate
from damperlab.worker.steady.variational import SIZE

# Half cycles between looks at the section; even, so that whole cycles lie between. Fewer where a half cycle takes long.
_CHUNK = 32
_SHORT_CHUNK = 8
_LONG_HALF = 1000  # windows
_TRANSIENT_LEFT = 0.01  # share of a free vibration that is left after the burn-in
_LARGEST_BURN_IN = 0.2  # of max_cycles: a structure without damping has no other bound
_FEWEST_MEASURED = 768  # cycles before a standard error is believed
_CORRELATIONS = 50.0  # correlation times that have to be measured
_MARGIN = 1.1  # of the cycles that the next look is planned at, over those that the last one asks for
_SPARE_EVENTS = 20_000
_MOST_BESIDE = 0.1  # half cycles spent on looking for orbits nearby, beside those of the run
_NEWTON_STEPS = 4  # that Newton's method takes at the least
_REPELS = 1e-6  # by how much the largest multiplier of an orbit that repels exceeds one
_REACH = 0.1  # relative distance over which an orbit may be the one that the run approaches
# Share of the first distance to an orbit to which the run has to come; and if it has followed the linearisation for long.
_CLOSED_IN = 0.3
_CLOSED_IN_SLOWLY = 0.7
_LONG = 256  # half cycles
_AT_THE_ORBIT = 1e-8  # relative distance that is as good
# Excess displacement, over min(1, r⁴), below which creep towards the locked set cannot overshoot it.
_CREEP = 1e-2
_TIE = 1e-12


class Settings(NamedTuple):
    """When to stop: the study's `steady` block; and whether energies are measured (as in `scene.Meter`)."""

    max_cycles: int
    tolerance: float
    periodic_tolerance: float
    energies: bool | None = True


class Orbit(NamedTuple):
    """A periodic orbit.

    Attributes
    ----------
    state : State
        On it, at phase 0.
    lag : int
        Period in mirrored half cycles; 0: none.
    error : float
        Distance from periodicity.
    """

    state: State
    lag: int
    error: float


class Candidate(NamedTuple):
    """A stable orbit that waits for the run to close in on it.

    Attributes
    ----------
    orbit : Orbit
    met : int
        Half cycle of the run at which it was found.
    since : int
        Half cycle of the run's departure from it that was noted last.
    share : float
        Of the first distance, what was left then.
    """

    orbit: Orbit
    met: int
    since: int
    share: float


class Look(NamedTuple):
    """What a look at the section starts from.

    Attributes
    ----------
    half : int
        Half cycles of the run.
    scale : float
        Size of the motion.
    size : int
        Leading section coordinates that take part.
    """

    half: int
    scale: float
    size: int


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
        Of the metered cycles, where it does not repeat.
    known : bool
        Whether that mean is known to the tolerance.
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
    burn_in = _burn_in(scene.base, settings) // chunk * chunk
    outcome = ARRIVED
    half = 0
    metered = -1  # half cycles
    next_look = _FEWEST_MEASURED
    next_try = _CHUNK
    none = Orbit(state, 0, inf)
    candidate = Candidate(none, 0, 0, 1.0)
    rival = False
    beside = 0  # half cycles spent on looking for orbits
    look = Look(0, 1.0, SIZE)
    mean = Estimate(0, 0, inf, inf, inf, False)
    while half < most and work_done(scene, half) <= most_work:
        if metered < 0 and (half >= burn_in or work_done(scene, half) >= _LARGEST_BURN_IN * most_work):
            metered = 0
            begin_trace(state, scene, notes)
        span = min(chunk, most - half)
        state, half, outcome = advance(state, half, span, metered, scene, notes)
        look = Look(half, extent(ring, half), active_size(state, particle, scene.counts))
        if outcome != ARRIVED:
            return Found(state, outcome, look, none, mean, False)
        if metered >= 0:
            metered += span
        if friction is not None:
            if scene.counts[IMPACTS] == 0:
                limit, crept = _creep_limit(state, friction, scene.base.frequency_ratio)
                if crept or _is_locked(state, friction, scene.base.frequency_ratio, ring, half):
                    return Found(limit, ARRIVED, look, Orbit(limit, 2, 0.0), mean, True)
        orbit = _repeated(state, look, span, scene, probe, particle, notes, settings)
        if orbit.lag > 0:
            return Found(orbit.state, ARRIVED, look, orbit, mean, True)
        for i in range(1, min(LONGEST, half // 2) + 1):
            notes.before[i] = recurrence(ring, half, i)
        if candidate.orbit.lag > 0:
            candidate, arrives = _closing_in(candidate, look, scene, probe, particle, notes)
            if arrives:
                return Found(candidate.orbit.state, ARRIVED, look, candidate.orbit, mean, True)
            if candidate.orbit.lag == 0:
                next_try = half + half // 2
                rival = True
        elif half >= next_try:
            next_try = half + _CHUNK
            spare = _MOST_BESIDE * half + _CHUNK - beside
            candidate, arrives, halves = _stable_orbit_nearby(
                state, look, spare, scene, probe, particle, notes
            )
            beside += halves
            if arrives:
                return Found(candidate.orbit.state, ARRIVED, look, candidate.orbit, mean, True)
        if metered >= 2 * next_look:
            cycle_peaks(notes.trace, metered, notes.cycles)
            mean = estimate(notes.cycles[:, 0], 0, metered // 2)
            if _is_known(mean, settings) and not rival:
                return Found(state, ARRIVED, look, none, mean, True)
            next_look = _next_look(mean, settings)
    if metered < 0:  # nothing was left after the burn-in
        metered = 0
        begin_trace(state, scene, notes)
    if metered < 2:
        state, half, outcome = advance(state, half, 2, metered, scene, notes)
        metered += 2
        if outcome != ARRIVED:
            return Found(state, outcome, look, none, mean, False)
    cycle_peaks(notes.trace, metered, notes.cycles)
    mean = estimate(notes.cycles[:, 0], 0, metered // 2)
    return Found(state, ARRIVED, look, none, mean, _is_known(mean, settings))


@kernel
def _burn_in(base, settings):
    """Half cycles after which the slowest free vibration, that of the structure, has all but died: it falls as e^(−ζτ).

    Until `_TRANSIENT_LEFT` of it is left, ln(100) r/(2πζ) = 0.73 r/ζ cycles. What then is still no steady response is found by
    its data (`statistics.estimate`).
    """
    most = _LARGEST_BURN_IN * settings.max_cycles
    if base.two_zeta <= 0.0:
        return 2 * int(most)
    needed = -log(_TRANSIENT_LEFT) * base.frequency_ratio / (pi * base.two_zeta)
    return 2 * int(min(needed, most))


@kernel
def _is_known(mean, settings):
    """Whether the mean of a response that does not repeat is known to the tolerance, from enough of it, without a drift."""
    measured = mean.last - mean.first
    return (
        mean.error <= settings.tolerance * mean.mean
        and measured >= _FEWEST_MEASURED
        and measured >= _CORRELATIONS * mean.correlation
        and mean.stationary
    )


@kernel
def _next_look(mean, settings):
    """Metered cycles of the next look, planned from this one.

    Looks are few, and each at a length fixed before its data are seen: a mean that was looked at again and again, until its
    error happened to be small, would be off by more than its error.
    """
    measured = mean.last - mean.first
    needed = max(
        measured * (mean.error / (settings.tolerance * mean.mean)) ** 2, _CORRELATIONS * mean.correlation
    )
    return mean.first + int(min(max(_MARGIN * needed, 1.25 * measured), 3.0 * measured))


@kernel
def _creep_limit(state, friction, frequency_ratio):
    """Locked state that a one-sided creep tends to.

    For γ_F ≥ r² every rest position |v| ≤ γ_F − r² is locked for good. From just outside, each cycle slips inwards by
    less than the excess squared, so the edge is reached only as 1/N: take the limit instead of stepping towards it.
    """
    square = frequency_ratio * frequency_ratio
    edge = friction - square
    if edge < 0.0 and edge > -_TIE * square:
        edge = 0.0  # γ_F = r² but for the rounding of r²
    # a slip of the excess force x lasts about √(8x)/r² and goes about x²/r⁴ far
    if edge >= 0.0 and state.slip == 0.0 and edge < abs(state.v) <= edge + _CREEP * min(1.0, square * square):
        v = edge if state.v > 0.0 else -edge
        return State(v, 0.0, 0.0, state.wall, state.gap, state.p_rate, state.riding, 0, 0, state.dwell), True
    return state, False


@kernel
def _is_locked(state, friction, frequency_ratio, ring, half):
    """Whether friction has held the mass for a cycle and holds it for good: r² + |v| ≤ γ_F, and the particle is at rest."""
    return (
        state.slip == 0.0
        and state.p_rate == 0.0
        and frequency_ratio * frequency_ratio + abs(state.v) <= friction
        and recurrence(ring, half, 2) == 0.0
    )


@kernel
def _repeated(state, look, span, scene, probe, particle, notes, settings):
    """The orbit on which the run all but repeats; of lag 0 where it does not, or where the orbit repels it.

    An orbit that repels the run was met by chance: where friction stops the mass, chaos has few dimensions and comes back to
    a point very nearly. Where Newton fails, or leads elsewhere, the run's own state is the answer, once it has repeated for
    as long as is remembered.
    """
    tolerance = settings.periodic_tolerance
    lag, error = settled_period(notes.ring, look.half, notes.before, span, look.scale, tolerance)
    if lag == 0:
        return Orbit(state, 0, inf)
    orbit, complete, _ = _newton(state, lag, look.scale, look, scene, probe, particle, notes)
    if orbit.error < inf:
        coordinates(orbit.state, particle, notes.orbit)
        moved = 0.0
        for i in range(look.size):
            moved = max(moved, abs(notes.orbit[i] - notes.ring[look.half % RING, i]))
        if moved > 100.0 * error + 1e-9 * look.scale:
            orbit = Orbit(state, lag, inf)
    if orbit.error == inf:
        orbit = Orbit(state, lag, error)
        base, free, loaded, friction, _, work, counts = probe
        begin_beside(probe, scene, lag)
        _, complete = around(
            state, lag, base, free, loaded, friction, particle, work, counts, notes.log, notes.monodromy
        )
        if not stays_closed(notes.ring, look.half, lag, tolerance * look.scale):
            return Orbit(state, 0, inf)
    if complete and spectral_radius(notes.monodromy, look.size) > 1.0 + _REPELS:
        return Orbit(state, 0, inf)
    return orbit


@kernel
def _newton(state, lag, reach, look, scene, probe, particle, notes):
    """Periodic orbit by Newton from a state of the run, its error infinite where there is none; its Jacobian in the notes."""
    base, free, loaded, friction, _, work, counts = probe
    begin_beside(probe, scene, 12 * lag)
    orbit, error, halves = find_orbit(
        state,
        lag,
        look.scale,
        reach,
        base,
        free,
        loaded,
        friction,
        particle,
        work,
        counts,
        notes.log,
        notes.monodromy,
    )
    return Orbit(orbit, lag, error), error < inf, halves


@kernel
def _stable_orbit_nearby(state, look, spare, scene, probe, particle, notes):
    """A stable orbit within reach of the run, noted for its confirmation; whether the run can but tend to it; half cycles.

    Newton is not begun where it would take more half cycles than there are to `spare`.
    """
    nothing = Candidate(Orbit(state, 0, inf), 0, 0, 1.0)
    lag = near_period(notes.ring, look.half, look.scale)
    if lag == 0 or _NEWTON_STEPS * lag > spare:
        return nothing, False, 0
    reach = inf if particle is None else 2.0 * _REACH * look.scale
    orbit, found, halves = _newton(state, lag, reach, look, scene, probe, particle, notes)
    if not found or not spectral_radius(notes.monodromy, look.size) < 1.0 - 1e-9:
        return nothing, False, halves
    point = notes.ring[look.half % RING]
    coordinates(orbit.state, particle, notes.orbit)
    for i in range(SIZE):
        notes.departure[i] = point[i] - notes.orbit[i]
        if particle is not None:
            if abs(notes.departure[i]) > _REACH * look.scale:
                return nothing, False, halves
    certain = _attracts_all(orbit, point, scene, probe, particle, notes)
    return Candidate(orbit, look.half, look.half, 1.0), certain, halves


@kernel
def _attracts_all(orbit, point, scene, probe, particle, notes):
    """Whether the run can but tend to a stable orbit.

    Without impacts v'' + 2ζv' + v + γ Sgn(v') = f is monotone: the distance √(Δv² + Δw²) of any two motions never grows. So
    a stable periodic one attracts them all, unless the mass may still come to a wall on its way.
    """
    if particle is not None:
        if scene.counts[IMPACTS] > 0 or point[3] != 0.0:
            return False
        begin_beside(probe, scene, 2)
        far = sqrt((point[0] - notes.orbit[0]) ** 2 + (point[1] - notes.orbit[1]) ** 2)
        meter = Meter(np.zeros(METERS), notes.meter.energies)
        state = orbit.state
        for _ in range(2):
            state, outcome = half_cycle(state, probe, meter, None)
            if outcome != ARRIVED:
                return False
        return meter.sums[PEAK] + far + abs(point[2]) < particle.clearance_ratio
    return True


@kernel
def _closing_in(candidate, look, scene, probe, particle, notes):
    """A candidate after a further stretch of the run, of lag 0 where the run leaves it; and whether the run tends to it.

    The run has to close in on the orbit just as its linearisation says, stretch after stretch, until it is nearer by
    `_CLOSED_IN`, or has done so for `_LONG`: a run may look for a while as if it approached an orbit of which the basin ends
    close by.
    """
    orbit = candidate.orbit
    nothing = Candidate(Orbit(orbit.state, 0, inf), 0, 0, 1.0)
    periods = (look.half - candidate.since) // orbit.lag
    at = candidate.since + periods * orbit.lag
    point = notes.ring[at % RING]
    verdict = follows(point, notes.orbit, notes.departure, notes.monodromy, periods, look.size, look.scale)
    if verdict == LEAVES:
        return nothing, False
    if verdict != APPROACHES:
        return candidate, False
    if scene.counts[IMPACTS] == 0:
        certain = _attracts_all(orbit, point, scene, probe, particle, notes)
        return (candidate, True) if certain else (nothing, False)
    first = 0.0
    now = 0.0
    for i in range(look.size):
        first += notes.departure[i] ** 2
        notes.departure[i] = point[i] - notes.orbit[i]
        now += notes.departure[i] ** 2
    share = candidate.share * (sqrt(now / first) if first > 0.0 else 0.0)
    enough = _CLOSED_IN_SLOWLY if look.half - candidate.met >= _LONG else _CLOSED_IN
    arrives = share <= enough or sqrt(now) <= _AT_THE_ORBIT * look.scale
    return Candidate(orbit, candidate.met, at, share), arrives
