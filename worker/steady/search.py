"""The run towards the steady response: on until it repeats, until the orbit it tends to is known, or until its mean is."""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.state import ARRIVED, IMPACTS, METERS, PEAK, Meter, State
from damperlab.worker.steady.eigenvalues import spectral_radius
from damperlab.worker.steady.energy import stored_energy
from damperlab.worker.steady.orbit import (
    APPROACHES,
    LEAVES,
    active_size,
    around,
    coordinates,
    find_orbit,
    follows,
)
from damperlab.worker.steady.run import advance, metered_cycle
from damperlab.worker.steady.section import LONGEST, RING, extent, near_period, recurrence, settled_period
from damperlab.worker.steady.statistics import mean_and_error
from damperlab.worker.steady.variational import SIZE

_CHUNK = 32  # half cycles between looks at the section; even, so that a chunk holds whole cycles
_BURN_IN = 0.2  # share of max_cycles taken as transient when the response turns out not to be periodic
_FEWEST_MEASURED = 512  # cycles before a standard error is believed
_REPELS = 1e-6  # by how much the largest multiplier of an orbit that repels exceeds one
_REACH = 0.1  # relative distance over which an orbit may be the one that the run approaches
# Excess displacement, over min(1, r⁴), below which creep towards the locked set cannot overshoot it.
_CREEP = 1e-2
_TIE = 1e-12


class Settings(NamedTuple):
    """When to stop: the study's `steady` block; and whether energies are measured (as in `state.Meter`)."""

    max_cycles: int
    tolerance: float
    periodic_tolerance: float
    energies: bool | None = True


class Found(NamedTuple):
    """What a run came to.

    Attributes
    ----------
    state : State
        On the orbit, or where the run stopped.
    outcome : int
        ARRIVED, or how the march ended early.
    half, extra : int
        Half cycles of the run; half cycles spent on orbits beside it.
    lag : int
        Period in mirrored half cycles; 0 where the response was not found to repeat.
    error : float
        Distance from periodicity.
    scale : float
        Size of the motion.
    size : int
        Leading section coordinates that take part.
    metered_from, impacts, stored
        The cycle from which the run was metered (−1: not), with the impacts and the stored energy there.
    """

    state: State
    outcome: int
    half: int
    extra: int
    lag: int
    error: float
    scale: float
    size: int
    metered_from: int
    impacts: int
    stored: float


@kernel
def search(start, scene, friction, particle, notes, settings):
    """March from a state until the steady response is known, or to `max_cycles`.

    Parameters
    ----------
    start : State
        At phase 0.
    scene : Scene
        What is marched in.
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
    ring, before, counts = notes.ring, notes.before, scene.counts
    state = start
    coordinates(state, particle, ring[0])
    outcome = ARRIVED
    half = 0
    extra = 0
    lag = 0
    error = inf
    scale = 1.0
    size = SIZE
    metered_from = -1
    impacts = 0
    stored = 0.0
    next_look = 0
    next_try = _CHUNK
    orbit = state
    period = 0  # of an orbit that waits for the run to confirm it
    orbit_error = inf
    met_at = 0
    burn_in = 2 * int(_BURN_IN * settings.max_cycles) // _CHUNK * _CHUNK
    while half < 2 * settings.max_cycles:
        if metered_from < 0 and half >= burn_in:
            metered_from = half // 2
            impacts = counts[IMPACTS]
            stored = stored_energy(state, scene.base.frequency_ratio, particle)
            next_look = metered_from + _FEWEST_MEASURED
        span = min(_CHUNK, 2 * settings.max_cycles - half)
        state, half, outcome = advance(state, half, span, metered_from >= 0, scene, notes)
        if outcome != ARRIVED:
            break
        scale = extent(ring, half)
        size = active_size(state, particle, counts)
        if friction is not None:
            if counts[IMPACTS] == 0:
                state, crept = _creep_limit(state, friction, scene.base.frequency_ratio)
                if crept:
                    lag, error = 2, 0.0
                    break
        lag, error = settled_period(ring, half, before, span, scale, settings.periodic_tolerance)
        if lag > 0:
            state, error, repels, halves = _polished(
                state, ring[half % RING], lag, error, scale, size, scene, particle, notes
            )
            extra += halves
            if not repels:
                break
            lag = 0
        for i in range(1, min(LONGEST, half // 2) + 1):
            before[i] = recurrence(ring, half, i)
        if period > 0:
            verdict, halves = _verdict(
                orbit, half - met_at, period, half, scale, size, scene, particle, notes
            )
            extra += halves
            if verdict == APPROACHES:
                state, lag, error = orbit, period, orbit_error
                break
            if verdict == LEAVES:
                period = 0
                next_try = half + half // 2
        elif half >= next_try:
            next_try = half + max(_CHUNK, half // 4)
            period = near_period(ring, half, scale)
            if period > 0:
                orbit, orbit_error, halves = _stable_orbit(
                    state, period, ring[half % RING], scale, size, scene, particle, notes
                )
                extra += halves
                met_at = half
                if orbit_error == inf:
                    period = 0
                else:
                    certain, halves = _attracts_all(orbit, ring[half % RING], scene, particle, notes)
                    extra += halves
                    if certain:
                        state, lag, error = orbit, period, orbit_error
                        break
        cycle = half // 2
        if metered_from >= 0 and cycle >= next_look:
            mean, deviation = mean_and_error(notes.peaks[:, 0], metered_from, cycle)
            if deviation <= settings.tolerance * mean:
                break
            next_look = metered_from + 2 * (cycle - metered_from)
    return Found(state, outcome, half, extra, lag, error, scale, size, metered_from, impacts, stored)


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
def _polished(state, point, lag, error, scale, size, scene, particle, notes):
    """The orbit beside a run that has all but closed on it: its error, whether it repels, the half cycles that it took.

    Where Newton fails, or leaves for another orbit, the run's own state stays the answer. An orbit that repels the run was
    met by chance: where friction stops the mass, chaos has few dimensions and comes back to a point very nearly.
    """
    base, free, loaded, friction, _, work, counts = scene
    orbit, distance, halves = find_orbit(
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
        notes.log,
        notes.monodromy,
    )
    coordinates(orbit, particle, notes.orbit)
    moved = 0.0
    for i in range(size):
        moved = max(moved, abs(notes.orbit[i] - point[i]))
    if distance < inf and moved <= 100.0 * error + 1e-9 * scale:
        state, error = orbit, distance
    else:
        _end, complete = around(
            state, lag, base, free, loaded, friction, particle, work, counts, notes.log, notes.monodromy
        )
        halves += lag
        if not complete:
            return state, error, False, halves
    return state, error, spectral_radius(notes.monodromy, size) > 1.0 + _REPELS, halves


@kernel
def _stable_orbit(state, period, point, scale, size, scene, particle, notes):
    """A stable orbit within reach of the run, noted for its confirmation; its error is inf where there is none."""
    base, free, loaded, friction, _, work, counts = scene
    orbit, error, halves = find_orbit(
        state,
        period,
        scale,
        inf if particle is None else 0.5 * scale,
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
    if not (error < inf and spectral_radius(notes.monodromy, size) < 1.0 - 1e-9):
        return orbit, inf, halves
    if particle is not None:
        coordinates(orbit, particle, notes.orbit)
        for i in range(SIZE):
            notes.departure[i] = point[i] - notes.orbit[i]
            if abs(notes.departure[i]) > _REACH * scale:
                error = inf
    return orbit, error, halves


@kernel
def _attracts_all(orbit, point, scene, particle, notes):
    """Whether the run can but tend to a stable orbit, and the half cycles spent on looking.

    Without impacts v'' + 2ζv' + v + γ Sgn(v') = f is monotone: the distance √(Δv² + Δw²) of any two motions never grows. So
    a stable periodic one attracts them all, unless the mass may still come to a wall on its way.
    """
    if particle is not None:
        if scene.counts[IMPACTS] > 0 or point[3] != 0.0:
            return False, 0
        far = sqrt((point[0] - notes.orbit[0]) ** 2 + (point[1] - notes.orbit[1]) ** 2)
        meter = Meter(np.zeros(METERS), notes.meter.energies)
        metered_cycle(orbit, scene, meter)
        return meter.sums[PEAK] + far + abs(point[2]) < particle.clearance_ratio, 2
    return True, 0


@kernel
def _verdict(orbit, since, period, half, scale, size, scene, particle, notes):
    """What the run has done about an orbit `since` it was noted, and the half cycles spent on looking."""
    periods = since // period
    at = notes.ring[(half - since + periods * period) % RING]
    verdict = follows(at, notes.orbit, notes.departure, notes.monodromy, periods, size, scale)
    halves = 0
    if verdict == APPROACHES and scene.counts[IMPACTS] == 0:
        certain, halves = _attracts_all(orbit, at, scene, particle, notes)
        if not certain:
            verdict = LEAVES
    return verdict, halves
