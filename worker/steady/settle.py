"""Computation of the steady response of one design point from a start state."""

from math import nan

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.scene import Scene, make_scene
from damperlab.worker.solver.sliding import down_of, rubs
from damperlab.worker.solver.state import State
from damperlab.worker.steady.orbits.newton import march_with_jacobian
from damperlab.worker.steady.orbits.orbit import orbit_multiplier
from damperlab.worker.steady.response.measures import (
    FEWEST_STUCK,
    Response,
    largest_of_run,
    mean_of_period,
    mean_of_run,
    measured_response,
    periodic_class,
    share_stuck,
    unmeasured,
)
from damperlab.worker.steady.response.trace import (
    acceleration_of_period,
    acceleration_of_run,
    stretch_of,
)
from damperlab.worker.steady.run import (
    Notes,
    advance,
    begin_probe,
    begin_trace,
    make_notes,
    probe_of,
)
from damperlab.worker.steady.search import Found, search
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, coordinates
from damperlab.worker.steady.stability.lyapunov import HALVES_FOLLOWED, is_chaotic
from damperlab.worker.steady.start import at_rest
from damperlab.worker.steady.stopping_rules import Settings

__all__ = ["Settings", "at_rest", "settle"]

_CONVERGED = int(Status.CONVERGED)
_LOCKED = int(ResponseClass.LOCKED)
_MAX_CYCLES = int(Status.MAX_CYCLES)
_MODULATED = int(ResponseClass.MODULATED)
_CHAOTIC = int(ResponseClass.CHAOTIC)
_CLOSED = 1e-9  # Relative distance within which a state repeats.
_ROUNDING = 1e-12  # Rounding error of displacements, over the amplitude of the excitation.


@kernel
def settle(
    damping_ratio: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    settings: Settings,
    start: State,
    forced: bool = False,
) -> tuple[Response, State]:
    """Compute the steady response of one design point.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    friction : float or None
        γ_F > 0; None for a kernel without friction.
    particle : Particle or None
        Particle with β > 0; None for a kernel without a particle.
    settings : Settings
        Rules for stopping the run.
    start : State
        State at phase 0, for example `start.at_rest`.
    forced : bool
        Whether a force on the structure replaces the shaken base. Lengths are then divided by F₀/k.

    Returns
    -------
    response : Response
        The response. The field `status` gives the outcome of the search; no error is raised.
    end : State
        State on the steady response, at phase 0 of the mirrored base.

    Notes
    -----
    The run ends as soon as one of these conditions is met:

    1. The run repeats, within rounding or within `periodic_tolerance`, on an orbit that does not repel the run.
    2. Newton's method finds a stable periodic orbit, and the run approaches this orbit as the linearisation predicts.
    3. Friction holds the mass permanently, or the mass creeps towards a permanently locked position.
    4. Under a force, the particle slows down, and the remaining displacement of the mass is within `tolerance`.
    5. After a burn-in, the standard error of the mean peak is below `tolerance`, a moving particle has met a wall, and
       the run does not tend to rest.
    6. `max_cycles` or the limit on events is reached.
    """
    scene = make_scene(damping_ratio, frequency_ratio, friction, particle, settings.energies, forced)
    notes = make_notes(settings.max_cycles, particle, settings.energies, settings.acceleration)
    return _settled(start, scene, probe_of(scene), notes, settings)


@kernel
def _settled(
    start: State, scene: Scene, probe: Scene, notes: Notes, settings: Settings
) -> tuple[Response, State]:
    """Compute the response for `settle`, with addresses in place of all arrays. The caller keeps the arrays alive.

    An address is one number, whereas numba passes an array as seven numbers and emits code for all seven.
    """
    scene, probe = on_addresses(scene), on_addresses(probe)
    notes = notes._replace(meter=on_addresses(notes.meter), log=on_addresses(notes.log))
    found = search(start, scene, probe, notes, settings)
    if found.outcome != ARRIVED:
        return unmeasured(found.outcome, found.look.half // 2), found.state
    if found.orbit.period_halves > 0:
        return _measured_orbit(found, scene, probe, notes, settings)
    return _measured_run(found, scene, probe, notes)


@kernel
def _measured_orbit(
    found: Found, scene: Scene, probe: Scene, notes: Notes, settings: Settings
) -> tuple[Response, State]:
    """Return the response over one period, and the state after this period.

    The response is converged only if the orbit itself is known to `settings.tolerance`.
    """
    state = found.orbit.state
    cycles = found.look.half // 2
    period_halves = _shortest_period(state, found, scene, probe, notes)
    # an odd period_halves is half a period of the response, so twice as many half cycles are measured
    halves = 2 * period_halves if period_halves % 2 == 1 else period_halves
    begin_probe(probe, scene, halves)
    begin_trace(state, probe, notes)
    state, _, outcome = advance(state, 0, halves, 0, probe, notes)
    if outcome != ARRIVED:
        return unmeasured(outcome, cycles), state
    stretch = stretch_of(notes.trace, 0, halves)
    begin_probe(probe, scene, period_halves)
    multiplier = nan
    _, complete = march_with_jacobian(state, period_halves, probe, notes.log, notes.monodromy)
    if complete:
        size = found.look.size
        if stretch.impacts == 0.0:
            size = SECTION_SIZE - 1 if rubs(scene.particle) else 2
        multiplier = orbit_multiplier(notes.monodromy, size, period_halves)
    stuck = share_stuck(stretch, probe.base.frequency_ratio)
    response_class, period = periodic_class(
        period_halves, stuck, stretch.impacts, rubs(scene.particle) and stretch.sliding == 0.0
    )
    error = found.orbit.error + found.way_left
    mean = mean_of_period(notes.trace, period_halves, error)
    # a response as small as rounding errors cannot be known more accurately
    is_known = found.known and found.orbit.error <= settings.tolerance * max(mean.amplitude, _ROUNDING)
    status = _CONVERGED if is_known else _MAX_CYCLES
    response = measured_response(
        stretch,
        notes.meter.energies,
        probe.base.frequency_ratio,
        mean,
        acceleration_of_period(notes.trace, period_halves, halves, notes.meter.acceleration),
    )._replace(
        amplitude_error=error,
        response_class=response_class,
        period=period,
        floquet_multiplier=multiplier,
        cycles=cycles,
        status=status,
    )
    # if the particle still moves, a continuation starts from the state at the end of the run
    return response, state if found.way_left == 0.0 else found.state


@kernel
def _measured_run(found: Found, scene: Scene, probe: Scene, notes: Notes) -> tuple[Response, State]:
    """Return the response over the metered stretch of a run that does not repeat, and the final state of the run."""
    state = found.state
    mean = found.mean
    stretch = stretch_of(notes.trace, 2 * mean.first, 2 * mean.last)
    response_class = _MODULATED
    # without a particle all motions converge: see `candidate.attracts_all`
    if probe.particle is not None:
        if share_stuck(stretch, probe.base.frequency_ratio) >= FEWEST_STUCK:
            response_class = _LOCKED  # only the motion of the particle does not repeat
        else:
            begin_probe(probe, scene, HALVES_FOLLOWED)
            if is_chaotic(state, found.look.half // 2, probe, notes.log, found.look.size):
                response_class = _CHAOTIC
    peaks = mean_of_run(notes.trace, notes.cycles, notes.series, mean.first, mean.last)
    peak, speed = largest_of_run(notes.trace, stretch, peaks)
    response = measured_response(
        stretch,
        notes.meter.energies,
        probe.base.frequency_ratio,
        peaks,
        acceleration_of_run(notes.trace, mean.first, mean.last, notes.meter.acceleration),
    )._replace(
        amplitude_ratio_max=peak,
        amplitude_error=mean.error,
        response_class=response_class,
        impact_speed_max=speed,
        cycles=found.look.half // 2,
        status=_CONVERGED if found.known else _MAX_CYCLES,
    )
    return response, state


@kernel
def _shortest_period(state: State, found: Found, scene: Scene, probe: Scene, notes: Notes) -> int:
    """Shortest period after which the state repeats within the error of the orbit: a divisor of the orbit's period.

    There is no search for another orbit, because just beyond a period doubling a shorter, repelling orbit is
    very near.
    """
    period_halves = found.orbit.period_halves
    known = _CLOSED * found.look.scale + 100.0 * found.orbit.error
    start = np.empty(SECTION_SIZE)
    end = np.empty(SECTION_SIZE)
    coordinates(state, scene.particle, start)
    for shorter in range(1, period_halves):
        if period_halves % shorter == 0:
            begin_probe(probe, scene, shorter)
            there, complete = march_with_jacobian(state, shorter, probe, notes.log, notes.monodromy)
            coordinates(there, scene.particle, end)
            # half a cycle is not a period under gravity, because gravity is not mirrored
            if complete and down_of(there.slide) == down_of(state.slide) and _is_near(end, start, known):
                return shorter
    return period_halves


@kernel
def _is_near(point: NDArray[np.float64], other: NDArray[np.float64], known: float) -> bool:
    """Whether two section points agree within `known` in every coordinate."""
    near = True
    for i in range(SECTION_SIZE):
        near = near and abs(point[i] - other[i]) <= known
    return near
