"""From rest to the steady response of one design point, and its measures."""

from math import inf, nan, pi, sqrt
from typing import NamedTuple

import numpy as np

from studies.variables import ResponseClass, Status
from worker.jit import kernel
from worker.solver.march import half_cycle
from worker.solver.scene import (
    ARRIVED,
    BUDGET,
    COUNTS,
    FRICTION_LOSS,
    IMPACT_LOSS,
    IMPACTS,
    METERS,
    PEAK,
    RELATIVE_PEAK,
    SPEED,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    State,
)
from worker.solver.taylor import TERMS
from worker.solver.windows import make_base, make_medium
from worker.steady.energy import energy_residual, stored_energy
from worker.steady.section import COORDINATES, LONGEST, RING, extent, recurrence, section_point
from worker.steady.statistics import mean_and_error

_CONVERGED = int(Status.CONVERGED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_UNKNOWN = int(ResponseClass.UNKNOWN)
_LOCKED = int(ResponseClass.LOCKED)
_NO_IMPACT = int(ResponseClass.NO_IMPACT)
_SYMMETRIC = int(ResponseClass.SYMMETRIC)
_ASYMMETRIC = int(ResponseClass.ASYMMETRIC)
_SUBHARMONIC = int(ResponseClass.SUBHARMONIC)
_MODULATED = int(ResponseClass.MODULATED)

_CHUNK = 64  # half cycles between looks at the section; even, so that a chunk holds whole cycles
_BURN_IN = 0.2  # share of max_cycles taken as transient when the response turns out not to be periodic
_FEWEST_MEASURED = 512  # cycles before a standard error is believed
_ROUNDING = 1e-13  # recurrence of a settled response, relative
_SAME = 1e-6  # relative recurrence below which a settled response has this period, not a multiple of it
_FEWEST_STUCK = (
    1.0 - 1e-6
)  # share of time from which a mass counts as locked: at γ_F = r² it touches slip at one instant
_CREEP = 1e-2  # excess displacement below which creep towards the locked set cannot overshoot it
_SEGMENTS_PER_CYCLE = 2000  # budget: beyond it impacts follow each other too fast to resolve


class Settings(NamedTuple):
    """When to stop: the study's `steady` block."""

    max_cycles: int
    tolerance: float
    periodic_tolerance: float


class Response(NamedTuple):
    """The measures of one design point, named as in `studies.variables`."""

    amplitude_ratio: float
    amplitude_ratio_max: float
    amplitude_ratio_rms: float
    relative_amplitude_ratio: float
    amplitude_error: float
    energy_residual: float
    response_class: int
    period: int
    floquet_multiplier: float
    impacts_per_cycle: float
    impact_speed_max: float
    stick_fraction: float
    dissipation_viscous: float
    dissipation_friction: float
    dissipation_impact: float
    cycles: int
    status: int


@kernel
def failed(status, cycles):
    """Response of a point whose march ended early."""
    return Response(
        nan, nan, nan, nan, nan, nan, _UNKNOWN, 0, nan, nan, nan, nan, nan, nan, nan, cycles, status
    )


@kernel
def at_rest(frequency_ratio, friction, particle):
    """Everything at rest in the absolute frame, particle centred: v' = −r."""
    slip = 0.0
    if friction is not None:
        slip = -1.0
    gap = 0.0
    if particle is not None:
        gap = particle.clearance_ratio
    return State(0.0, -frequency_ratio, slip, 1.0, gap, 0.0, 0.0, 0, 0)


@kernel
def _recurring(ring, now, before, scale, tolerance):
    """Shortest period [half cycles] to which the march has settled, 0 for none, and the distance from it.

    The recurrence of a settling response falls by λ a period, and what is left of the way is the sum of the geometric
    series, d λ/(1 − λ). λ is read from the recurrence `before` a chunk ago.
    """
    for lag in range(1, LONGEST + 1):
        d = recurrence(ring, now, lag)
        earlier = before[lag]
        if d <= _ROUNDING * scale and earlier <= 10.0 * _ROUNDING * scale:
            return lag, d
        if d < earlier and earlier > 0.0:
            rate = (d / earlier) ** (lag / _CHUNK)
            left = d * rate / (1.0 - rate)
            if left <= tolerance * scale and earlier <= 0.01 * scale:
                return lag, left
    return 0, inf


@kernel
def _creep_limit(state, friction, frequency_ratio):
    """Locked state that a one-sided creep tends to.

    For γ_F ≥ r² every rest position |v| ≤ γ_F − r² is locked for good. From just outside, each cycle slips inwards by less
    than the excess squared, so the edge is reached only as 1/N: take the limit instead of stepping towards it.
    """
    edge = friction - frequency_ratio * frequency_ratio
    if edge >= 0.0 and state.slip == 0.0 and edge < abs(state.v) <= edge + _CREEP:
        v = edge if state.v > 0.0 else -edge
        return State(v, 0.0, 0.0, state.wall, state.gap, state.p_rate, state.riding, 0, 0), True
    return state, False


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
    """
    base = make_base(damping_ratio, frequency_ratio)
    free = make_medium(base, 1.0)
    loaded = None
    if particle is not None:
        loaded = make_medium(base, 1.0 + particle.mass_ratio)
    work = np.empty((4, TERMS))
    counts = np.zeros(COUNTS, np.int64)
    counts[BUDGET] = _SEGMENTS_PER_CYCLE * (settings.max_cycles + 50)
    ring = np.zeros((RING, COORDINATES))
    before = np.full(LONGEST + 1, inf)
    peaks = np.empty((settings.max_cycles + _CHUNK, 2))
    meter = np.zeros(METERS)
    state = at_rest(frequency_ratio, friction, particle)
    section_point(state, particle, ring[0])
    half = 0
    metered_from = -1
    stored = 0.0
    impacts_before = 0
    next_look = 0
    lag = 0
    error = inf
    while half < 2 * settings.max_cycles:
        if metered_from < 0 and half >= 2 * _BURN_IN * settings.max_cycles:
            metered_from = half // 2
            stored = stored_energy(state, frequency_ratio, particle)
            impacts_before = counts[IMPACTS]
            next_look = metered_from + _FEWEST_MEASURED
        for _ in range(min(_CHUNK, 2 * settings.max_cycles - half)):
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
                return failed(outcome, half // 2)
            section_point(state, particle, ring[half % RING])
        crept = False
        if friction is not None:
            if counts[IMPACTS] == 0:
                state, crept = _creep_limit(state, friction, frequency_ratio)
        scale = extent(ring, half)
        if crept:
            lag, error = 2, 0.0
            break
        if half > LONGEST:
            lag, error = _recurring(ring, half, before, scale, settings.periodic_tolerance)
            if lag > 0:
                for shorter in range(1, lag):
                    if lag % shorter == 0 and recurrence(ring, half, shorter) <= _SAME * scale:
                        lag = shorter
                        break
                break
            for i in range(1, LONGEST + 1):
                before[i] = recurrence(ring, half, i)
        cycle = half // 2
        if metered_from >= 0 and cycle >= next_look:
            mean, deviation = mean_and_error(peaks[:, 0], metered_from, cycle)
            if deviation <= settings.tolerance * mean:
                break
            next_look = metered_from + 2 * (cycle - metered_from)
    cycles = half // 2
    status = _CONVERGED
    if lag > 0:
        cycles_measured = lag if lag % 2 == 1 else lag // 2
        meter[:] = 0.0
        stored = stored_energy(state, frequency_ratio, particle)
        impacts_before = counts[IMPACTS]
        metered_from = 0
        for i in range(cycles_measured):
            meter[PEAK] = 0.0
            meter[RELATIVE_PEAK] = 0.0
            for _ in range(2):
                state, outcome = half_cycle(
                    state, base, free, loaded, friction, particle, work, counts, meter, None
                )
                if outcome != ARRIVED:
                    return failed(outcome, cycles + i)
            peaks[i, 0] = meter[PEAK]
            peaks[i, 1] = meter[RELATIVE_PEAK]
        cycles += cycles_measured
        measured_to = cycles_measured
    else:
        measured_to = cycles
        cycles_measured = measured_to - metered_from
        _mean, error = mean_and_error(peaks[:, 0], metered_from, measured_to)
        if not error <= settings.tolerance * _mean:
            status = _MAX_CYCLES
    amplitude = 0.0
    relative = 0.0
    largest = 0.0
    for i in range(metered_from, measured_to):
        amplitude += peaks[i, 0]
        relative += peaks[i, 1]
        largest = max(largest, peaks[i, 0])
    amplitude /= cycles_measured
    relative /= cycles_measured
    time = cycles_measured * 2.0 * pi / frequency_ratio
    residual = energy_residual(meter, stored, stored_energy(state, frequency_ratio, particle))
    losses = meter[VISCOUS_LOSS] + meter[FRICTION_LOSS] + meter[IMPACT_LOSS]
    share = (
        1.0 / losses if losses > 1e-12 * stored else 0.0
    )  # a locked mass loses nothing: no shares of rounding
    impacts = counts[IMPACTS] - impacts_before
    stuck = meter[STUCK] / time
    if lag == 0:
        kind = _MODULATED
        period = 0
    else:
        period = lag if lag % 2 == 1 else lag // 2
        if stuck >= _FEWEST_STUCK:
            kind = _LOCKED
            period = 1
        elif impacts == 0:
            kind = _NO_IMPACT
        elif lag == 1:
            kind = _SYMMETRIC
        elif lag == 2:
            kind = _ASYMMETRIC
        else:
            kind = _SUBHARMONIC
    return Response(
        amplitude,
        largest,
        sqrt(2.0 * meter[SQUARE] / time),
        relative,
        error,
        residual,
        kind,
        period,
        nan,
        impacts / cycles_measured,
        meter[SPEED],
        min(stuck, 1.0),
        meter[VISCOUS_LOSS] * share,
        meter[FRICTION_LOSS] * share,
        meter[IMPACT_LOSS] * share,
        cycles,
        status,
    )
