"""From a start state to the steady response of one design point."""

from math import nan

import numpy as np

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.jit import kernel
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.state import ARRIVED, IMPACTS, PEAK, RELATIVE_PEAK
from damperlab.worker.steady.energy import stored_energy
from damperlab.worker.steady.lyapunov import is_chaotic
from damperlab.worker.steady.orbit import around, coordinates, orbit_multiplier
from damperlab.worker.steady.response import failed, measured_response
from damperlab.worker.steady.run import make_notes, make_scene, metered_cycle
from damperlab.worker.steady.search import Settings, search
from damperlab.worker.steady.section import SAME
from damperlab.worker.steady.start import at_rest
from damperlab.worker.steady.statistics import mean_and_error
from damperlab.worker.steady.variational import SIZE

__all__ = ["Settings", "at_rest", "settle"]

_CONVERGED = int(Status.CONVERGED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_UNKNOWN = int(ResponseClass.UNKNOWN)
_MODULATED = int(ResponseClass.MODULATED)
_CHAOTIC = int(ResponseClass.CHAOTIC)
_LYAPUNOV_CYCLES = 320


@kernel
def settle(damping_ratio, frequency_ratio, friction, particle, settings, start):
    """Steady response of one design point.

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
    start : State
        At phase 0, as `start.at_rest`.

    Returns
    -------
    response : Response
        Its status tells how the search ended; nothing is raised.
    end : State
        On the response, at phase 0 of the mirrored base.

    Notes
    -----
    The run goes on until one of these holds. It repeats to rounding, or what is left of its way to repeating is below
    `periodic_tolerance`. Or Newton finds a periodic orbit, stable by its multipliers, and the next stretch of the run
    closes in on it just as its linearisation says: then it is the orbit that the run tends to, and the rest of the way
    need not be stepped. Or, beyond a burn-in, the batch-means error of the mean peak is below `tolerance`. Or
    `max_cycles` is reached.
    """
    scene = make_scene(
        damping_ratio, frequency_ratio, friction, particle, settings.max_cycles, settings.energies
    )
    notes = make_notes(settings.max_cycles, settings.energies)
    found = search(start, scene, friction, particle, notes, settings)
    if found.outcome != ARRIVED:
        return failed(found.outcome, (found.half + found.extra) // 2), found.state
    if found.lag > 0:
        return _measured_orbit(found, scene, particle, notes)
    return _measured_run(found, scene, particle, notes, settings)


@kernel
def _measured_orbit(found, scene, particle, notes):
    """Response over one period, and the state after it."""
    base, free, loaded, friction, _, work, counts = scene
    state = found.state
    meter = notes.meter
    lag = _shortest_period(state, found.lag, found.scale, scene, particle)
    period = (
        lag if lag % 2 == 1 else lag // 2
    )  # whole cycles: the mirrored map of an odd lag is half a period
    meter.sums[:] = 0.0
    stored = stored_energy(state, base.frequency_ratio, particle)
    impacts = counts[IMPACTS]
    for cycle in range(period):
        state, outcome = metered_cycle(state, scene, meter)
        notes.peaks[cycle, 0] = meter.sums[PEAK]
        notes.peaks[cycle, 1] = meter.sums[RELATIVE_PEAK]
        if outcome != ARRIVED:
            return failed(outcome, found.half // 2), state
    impacts = counts[IMPACTS] - impacts
    multiplier = nan
    _end, complete = around(
        state, lag, base, free, loaded, friction, particle, work, counts, notes.log, notes.monodromy
    )
    if complete:
        multiplier = orbit_multiplier(notes.monodromy, 2 if impacts == 0 else found.size, lag)
    response = measured_response(
        meter,
        notes.peaks,
        0,
        period,
        impacts,
        stored,
        stored_energy(state, base.frequency_ratio, particle),
        base.frequency_ratio,
        lag,
        _UNKNOWN,
        multiplier,
        found.error,
        found.half // 2 + period + (found.extra + lag + 1) // 2,
        _CONVERGED,
    )
    return response, state


@kernel
def _measured_run(found, scene, particle, notes, settings):
    """Response over the metered stretch of a run that does not repeat, and its end."""
    base, free, loaded, friction, _, work, counts = scene
    state = found.state
    cycles = found.half // 2
    impacts = counts[IMPACTS] - found.impacts
    mean, error = mean_and_error(notes.peaks[:, 0], found.metered_from, cycles)
    status = _CONVERGED if error <= settings.tolerance * mean else _MAX_CYCLES
    stretch = min(_LYAPUNOV_CYCLES, cycles)
    chaotic = is_chaotic(
        state, stretch, base, free, loaded, friction, particle, work, counts, notes.log, found.size
    )
    response = measured_response(
        notes.meter,
        notes.peaks,
        found.metered_from,
        cycles,
        impacts,
        found.stored,
        stored_energy(state, base.frequency_ratio, particle),
        base.frequency_ratio,
        0,
        _CHAOTIC if chaotic else _MODULATED,
        nan,
        error,
        cycles + (found.extra + 2 * stretch + 1) // 2,
        status,
    )
    return response, state


@kernel
def _shortest_period(state, lag, scale, scene, particle):
    """The shortest part of a period after which the state repeats already."""
    for shorter in range(1, lag):
        if lag % shorter == 0 and _closes(state, shorter, scale, scene, particle):
            return shorter
    return lag


@kernel
def _closes(state, lag, scale, scene, particle):
    """Whether a state repeats after `lag` mirrored half cycles."""
    base, free, loaded, friction, _, work, counts = scene
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
    return total <= SAME * scale
