"""From rest to the steady response of one design point."""

from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np

from studies.variables import ResponseClass, Status
from worker.jit import kernel
from worker.solver.dwell import dwell_at_rest
from worker.solver.march import half_cycle
from worker.solver.record import empty_log
from worker.solver.scene import ARRIVED, BUDGET, COUNTS, IMPACTS, METERS, PEAK, RELATIVE_PEAK, State
from worker.solver.taylor import TERMS
from worker.solver.windows import make_base, make_medium
from worker.steady.energy import stored_energy
from worker.steady.lyapunov import is_chaotic
from worker.steady.orbit import active_size, around, coordinates, find_orbit, follows, orbit_multiplier
from worker.steady.response import failed, measured_response
from worker.steady.section import LONGEST, RING, extent, recurrence
from worker.steady.statistics import mean_and_error
from worker.steady.tangent import SIZE, spectral_radius

_CONVERGED = int(Status.CONVERGED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_UNKNOWN = int(ResponseClass.UNKNOWN)
_MODULATED = int(ResponseClass.MODULATED)
_CHAOTIC = int(ResponseClass.CHAOTIC)

_CHUNK = 32  # half cycles between looks at the section; even, so that a chunk holds whole cycles
_BURN_IN = 0.2  # share of max_cycles taken as transient when the response turns out not to be periodic
_FEWEST_MEASURED = 512  # cycles before a standard error is believed
_ROUNDING = 1e-13  # recurrence of a settled response, relative
_SAME = 1e-6  # relative recurrence below which a settled response has this period, not a multiple of it
_NEAR = 0.05  # relative recurrence from which Newton is tried
_REACH = 0.1  # relative distance over which an orbit may be the one that the run approaches
_CREEP = (
    1e-2  # excess displacement, over min(1, r⁴), below which creep towards the locked set cannot overshoot it
)
_TIE = 1e-12
_SEGMENTS_PER_CYCLE = 2000  # budget: beyond it impacts follow each other too fast to resolve
_LOG_ROWS = 4096
_LYAPUNOV_CYCLES = 320


class Settings(NamedTuple):
    """When to stop: the study's `steady` block."""

    max_cycles: int
    tolerance: float
    periodic_tolerance: float


@kernel
def at_rest(frequency_ratio, friction, particle):
    """Everything at rest in the absolute frame, particle centred: v' = −r."""
    slip = 0.0
    if friction is not None:
        slip = -1.0
    gap = 0.0
    if particle is not None:
        gap = particle.clearance_ratio
    return State(0.0, -frequency_ratio, slip, 1.0, gap, 0.0, 0.0, 0, 0, dwell_at_rest(particle))


@kernel
def _recurring(ring, now, before, span, scale, tolerance):
    """Shortest period [half cycles] to which the march has settled, 0 for none, and the distance from it.

    The recurrence of a settling response falls by λ a period, and what is left of the way is the sum of the geometric
    series, d λ/(1 − λ). λ is read from the recurrence `before`, `span` half cycles ago.
    """
    found = 0
    left = inf
    for lag in range(1, LONGEST + 1):
        d = recurrence(ring, now, lag)
        earlier = before[lag]
        if d <= _ROUNDING * scale and earlier <= 10.0 * _ROUNDING * scale:
            found, left = lag, d
        elif d < earlier and earlier <= 0.01 * scale:
            rate = (d / earlier) ** (lag / span)
            if d * rate / (1.0 - rate) <= tolerance * scale:
                found, left = lag, d * rate / (1.0 - rate)
        if found > 0:
            break
    for shorter in range(1, found):
        if found % shorter == 0 and recurrence(ring, now, shorter) <= _SAME * scale:
            return shorter, left
    return found, left


@kernel
def _promising(ring, now, scale):
    """Shortest period [half cycles] that the run comes near to repeating, 0 for none."""
    for lag in range(1, LONGEST + 1):
        if recurrence(ring, now, lag) <= _NEAR * scale:
            return lag
    return 0


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
def _metered_cycle(state, base, free, loaded, friction, particle, work, counts, meter, peaks, cycle):
    """One excitation cycle with the meter on and its peaks noted."""
    meter[PEAK] = 0.0
    meter[RELATIVE_PEAK] = 0.0
    outcome = ARRIVED
    for _ in range(2):
        state, outcome = half_cycle(state, base, free, loaded, friction, particle, work, counts, meter, None)
        if outcome != ARRIVED:
            break
    peaks[cycle, 0] = meter[PEAK]
    peaks[cycle, 1] = meter[RELATIVE_PEAK]
    return state, outcome


@kernel
def settle(damping_ratio, frequency_ratio, friction, particle, settings):
    """Steady response of one design point from rest.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    friction : float or None
        γ_F > 0, or None: no friction in the kernel.
    particle : Particle or None
        With β > 0, or None: no particle in the kernel.
    settings : Settings
        When to stop.

    Returns
    -------
    Response
        Its status tells how the search ended; nothing is raised.

    Notes
    -----
    The run goes on until one of these holds. It repeats to rounding, or what is left of its way to repeating is below
    `periodic_tolerance`. Or Newton finds a periodic orbit, stable by its multipliers, and the next stretch of the run
    closes in on it just as its linearisation says: then it is the orbit that the run tends to, and the rest of the way
    need not be stepped. Or, beyond a burn-in, the batch-means error of the mean peak is below `tolerance`. Or
    `max_cycles` is reached.
    """
    base = make_base(damping_ratio, frequency_ratio)
    free = make_medium(base, 1.0)
    loaded = None
    if particle is not None:
        loaded = make_medium(base, 1.0 + particle.mass_ratio)
    work = np.empty((4, TERMS))
    counts = np.zeros(COUNTS, np.int64)
    counts[BUDGET] = _SEGMENTS_PER_CYCLE * (settings.max_cycles + 50)
    log = empty_log(_LOG_ROWS)
    ring = np.zeros((RING, SIZE))
    before = np.full(LONGEST + 1, inf)
    peaks = np.empty((settings.max_cycles + LONGEST, 2))
    meter = np.zeros(METERS)
    spare = np.zeros(METERS)
    monodromy = np.eye(SIZE)
    departure = np.zeros(SIZE)
    orbit_point = np.zeros(SIZE)
    state = at_rest(frequency_ratio, friction, particle)
    orbit = state
    coordinates(state, particle, ring[0])
    half = 0
    extra = 0  # half cycles of Newton's
    metered_from = -1
    stored = 0.0
    impacts_before = 0
    next_look = 0
    next_try = _CHUNK
    candidate = 0  # period of an orbit that waits for the run to confirm it
    candidate_error = inf
    candidate_at = 0
    lag = 0
    error = inf
    burn_in = 2 * int(_BURN_IN * settings.max_cycles) // _CHUNK * _CHUNK
    while half < 2 * settings.max_cycles:
        if metered_from < 0 and half >= burn_in:
            metered_from = half // 2
            stored = stored_energy(state, frequency_ratio, particle)
            impacts_before = counts[IMPACTS]
            next_look = metered_from + _FEWEST_MEASURED
        outcome = ARRIVED
        span = min(_CHUNK, 2 * settings.max_cycles - half)
        for _ in range(span):
            if metered_from < 0:
                state, outcome = half_cycle(
                    state, base, free, loaded, friction, particle, work, counts, None, None
                )
            else:
                if half % 2 == 0:
                    meter[PEAK] = 0.0
                    meter[RELATIVE_PEAK] = 0.0
                state, outcome = half_cycle(
                    state, base, free, loaded, friction, particle, work, counts, meter, None
                )
                peaks[half // 2, 0] = meter[PEAK]
                peaks[half // 2, 1] = meter[RELATIVE_PEAK]
            half += 1
            if outcome != ARRIVED:
                return failed(outcome, (half + extra) // 2)
            coordinates(state, particle, ring[half % RING])
        scale = extent(ring, half)
        size = active_size(friction, particle, counts)
        if friction is not None:
            if counts[IMPACTS] == 0:
                state, crept = _creep_limit(state, friction, frequency_ratio)
                if crept:
                    lag, error = 2, 0.0
                    break
        if half > LONGEST:
            lag, error = _recurring(ring, half, before, span, scale, settings.periodic_tolerance)
            if lag > 0:
                polished, distance, halves = find_orbit(
                    state,
                    lag,
                    scale,
                    scale,
                    base,
                    free,
                    loaded,
                    friction,
                    particle,
                    work,
                    counts,
                    log,
                    monodromy,
                )
                extra += halves
                coordinates(polished, particle, orbit_point)
                moved = 0.0
                for i in range(size):
                    moved = max(moved, abs(orbit_point[i] - ring[half % RING, i]))
                if distance < inf and moved <= 100.0 * error + 1e-9 * scale:
                    state, error = polished, distance
                break
            for i in range(1, LONGEST + 1):
                before[i] = recurrence(ring, half, i)
            if candidate > 0:
                periods = (half - candidate_at) // candidate
                at = ring[(candidate_at + periods * candidate) % RING]
                confirmed = follows(at, orbit_point, departure, monodromy, periods, size, scale)
                if particle is not None:
                    if confirmed and counts[IMPACTS] == 0:
                        # what is left of the transient must not carry the mass to a wall later
                        far = 0.0
                        for i in range(size):
                            far += (at[i] - orbit_point[i]) ** 2
                        _metered_cycle(
                            orbit,
                            base,
                            free,
                            loaded,
                            friction,
                            particle,
                            work,
                            counts,
                            spare,
                            peaks,
                            settings.max_cycles,
                        )
                        extra += 2
                        confirmed = spare[PEAK] + 1.5 * sqrt(far) < particle.clearance_ratio
                if confirmed:
                    state, lag, error = orbit, candidate, candidate_error
                    break
                candidate = 0
                next_try = 2 * half
            elif half >= next_try:
                promising = _promising(ring, half, scale)
                next_try = half + max(_CHUNK, half // 4)
                if promising > 0:
                    orbit, candidate_error, halves = find_orbit(
                        state,
                        promising,
                        scale,
                        inf if particle is None else 0.5 * scale,
                        base,
                        free,
                        loaded,
                        friction,
                        particle,
                        work,
                        counts,
                        log,
                        monodromy,
                    )
                    extra += halves
                    if candidate_error < inf and spectral_radius(monodromy, size) < 1.0 - 1e-9:
                        if particle is None:
                            # v'' + 2ζv' + v + γ Sgn(v') = f is monotone: the distance of any two motions never grows,
                            # so a stable periodic one attracts them all
                            state, lag, error = orbit, promising, candidate_error
                            break
                        coordinates(orbit, particle, orbit_point)
                        far = 0.0
                        for i in range(SIZE):
                            departure[i] = ring[half % RING, i] - orbit_point[i]
                            far = max(far, abs(departure[i]))
                        if far <= _REACH * scale:
                            candidate = promising
                            candidate_at = half
        cycle = half // 2
        if metered_from >= 0 and cycle >= next_look:
            mean, deviation = mean_and_error(peaks[:, 0], metered_from, cycle)
            if deviation <= settings.tolerance * mean:
                break
            next_look = metered_from + 2 * (cycle - metered_from)
    cycles = half // 2
    status = _CONVERGED
    multiplier = nan
    unsteady = _UNKNOWN
    if lag > 0:
        for shorter in range(1, lag):
            if lag % shorter == 0 and _closes(
                state, shorter, base, free, loaded, friction, particle, work, counts, scale
            ):
                lag = shorter
                break
        measured_to = lag if lag % 2 == 1 else lag // 2
        meter[:] = 0.0
        stored = stored_energy(state, frequency_ratio, particle)
        impacts_before = counts[IMPACTS]
        metered_from = 0
        for i in range(measured_to):
            state, outcome = _metered_cycle(
                state, base, free, loaded, friction, particle, work, counts, meter, peaks, i
            )
            if outcome != ARRIVED:
                return failed(outcome, cycles)
        cycles += measured_to
        impacts = counts[IMPACTS] - impacts_before
        after = stored_energy(state, frequency_ratio, particle)
        _end, complete = around(
            state, lag, base, free, loaded, friction, particle, work, counts, log, monodromy
        )
        if complete:
            multiplier = orbit_multiplier(monodromy, 2 if impacts == 0 else size, lag)
        extra += lag
    else:
        measured_to = cycles
        impacts = counts[IMPACTS] - impacts_before
        after = stored_energy(state, frequency_ratio, particle)
        mean, error = mean_and_error(peaks[:, 0], metered_from, measured_to)
        if not error <= settings.tolerance * mean:
            status = _MAX_CYCLES
        unsteady = _MODULATED
        stretch = min(_LYAPUNOV_CYCLES, cycles)
        if is_chaotic(state, stretch, base, free, loaded, friction, particle, work, counts, log, size):
            unsteady = _CHAOTIC
        extra += 2 * stretch
    return measured_response(
        meter,
        peaks,
        metered_from,
        measured_to,
        impacts,
        stored,
        after,
        frequency_ratio,
        lag,
        unsteady,
        multiplier,
        error,
        cycles + (extra + 1) // 2,
        status,
    )


@kernel
def _closes(state, lag, base, free, loaded, friction, particle, work, counts, scale):
    """Whether a state repeats after `lag` mirrored half cycles."""
    start = np.empty(SIZE)
    end = np.empty(SIZE)
    coordinates(state, particle, start)
    for _ in range(lag):
        state, outcome = half_cycle(state, base, free, loaded, friction, particle, work, counts, None, None)
        if outcome != ARRIVED:
            return False
    coordinates(state, particle, end)
    total = 0.0
    for i in range(SIZE):
        total = max(total, abs(end[i] - start[i]))
    return total <= _SAME * scale
