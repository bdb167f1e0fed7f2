"""Periodic orbits, found by Newton's method or from a run that repeats, and their multipliers."""

from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import filled
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.sliding import rubs
from damperlab.worker.solver.state import State
from damperlab.worker.steady.orbits.newton import march_with_jacobian, newton_step, norm
from damperlab.worker.steady.run import Notes, begin_probe
from damperlab.worker.steady.section.coordinates import (
    SECTION_SIZE,
    active_size,
    are_comparable,
    coordinates,
    state_at,
)
from damperlab.worker.steady.section.recurrence import RING, settled_period, stays_closed
from damperlab.worker.steady.stability.multipliers import spectral_radius
from damperlab.worker.steady.stopping_rules import Settings

_ITERATIONS = 10
_CLOSED = 1e-13  # largest relative residual of an orbit that is closed within rounding
_NEAR = 3e-3  # relative length of a step near an orbit, where the multipliers hardly change any more
_REPELS = 1e-6  # an orbit repels if its largest multiplier exceeds one by more than this value


class Orbit(NamedTuple):
    """A periodic orbit.

    Attributes
    ----------
    state : State
        State on the orbit, at phase 0.
    period_halves : int
        Period in mirrored half cycles; 0 if there is no orbit.
    error : float
        Distance from periodicity.
    """

    state: State
    period_halves: int
    error: float


class SectionLook(NamedTuple):
    """Data of a run at a section point, for the search for orbits.

    Attributes
    ----------
    half : int
        Number of half cycles of the run.
    scale : float
        Reference for relative distances (`recurrence.extent`).
    size : int
        Number of leading section coordinates that are used.
    """

    half: int
    scale: float
    size: int


@kernel
def no_orbit(state: State) -> Orbit:
    """Return an `Orbit` of period 0, which means no orbit."""
    return Orbit(state, 0, inf)


@kernel
def newton_orbit(
    state: State,
    period_halves: int,
    reach: float,
    most: float,
    look: SectionLook,
    scene: Scene,
    probe: Scene,
    notes: Notes,
) -> tuple[Orbit, bool, int]:
    """Search for a periodic orbit by Newton's method from a state of the run, with steps no longer than `reach`.

    Near an orbit, the search ends without a result if the largest multiplier exceeds `most`.

    Returns
    -------
    orbit : Orbit
        The orbit; its error is inf if no orbit was found. `notes.monodromy` contains the Jacobian.
    found : bool
    halves : int
        Number of half cycles integrated.
    """
    begin_probe(probe, scene, (_ITERATIONS + 2) * period_halves)
    friction, particle, size = scene.friction, scene.particle, look.size
    if not rubs(particle):  # without friction of the particle, the size follows from the present state
        size = active_size(state, particle, probe.counts)
    nothing = Orbit(state, period_halves, inf)
    point = np.empty(SECTION_SIZE)
    residual = np.empty(SECTION_SIZE)
    step = filled(SECTION_SIZE, 0.0)
    coordinates(state, particle, point)
    here = state
    halves = 0
    previous_length = inf
    for _ in range(_ITERATIONS):
        there, complete = march_with_jacobian(here, period_halves, probe, notes.log, notes.monodromy)
        halves += period_halves
        if not complete or not are_comparable(there, here, particle):
            return nothing, False, halves
        coordinates(there, particle, residual)
        for i in range(SECTION_SIZE):
            residual[i] -= point[i]
        if not newton_step(notes.monodromy, residual, here, size, friction, particle, step):
            return nothing, False, halves
        step_length = norm(step, size)
        is_closed = norm(residual, size) <= _CLOSED * look.scale
        if is_closed and (step_length <= _CLOSED * look.scale or step_length > 0.5 * previous_length):
            # no further step improves the orbit
            return Orbit(here, period_halves, step_length), step_length < inf, halves
        if not step_length <= min(reach, 2.0 * previous_length):  # most searches far from any orbit end here
            return nothing, False, halves
        if most < inf and step_length <= _NEAR * look.scale:
            if spectral_radius(notes.monodromy, look.size) > most:
                return nothing, False, halves
        previous_length = step_length
        for i in range(size):
            point[i] += step[i]
        here, possible = state_at(point, here, particle)
        if not possible:
            return nothing, False, halves
        coordinates(here, particle, point)  # a particle in sustained contact has moved with the mass
    return nothing, False, halves


@kernel
def repeated_orbit(
    state: State,
    look: SectionLook,
    stretch: int,
    scene: Scene,
    probe: Scene,
    notes: Notes,
    settings: Settings,
) -> Orbit:
    """Return the orbit on which the run almost repeats.

    The period of the orbit is 0 if the run does not repeat, or if the orbit repels the run.

    A chaotic run may come near a repelling orbit by chance, in particular if friction stops the mass. If Newton's
    method fails or leads to another orbit, the state of the run is taken as the orbit, provided that the run has
    repeated over all stored section points.
    """
    tolerance = settings.periodic_tolerance
    period_halves, error = settled_period(
        notes.ring, look.half, notes.recurrences, notes.recurrences_before, stretch, look.scale, tolerance
    )
    if period_halves == 0:
        return no_orbit(state)
    orbit, complete, _ = newton_orbit(state, period_halves, look.scale, inf, look, scene, probe, notes)
    if orbit.error < inf:
        point = np.empty(SECTION_SIZE)
        coordinates(orbit.state, scene.particle, point)
        moved = 0.0
        for i in range(look.size):
            moved = max(moved, abs(point[i] - notes.ring[look.half % RING, i]))
        if moved > 100.0 * error + 1e-9 * look.scale:
            orbit = Orbit(state, period_halves, inf)
    if orbit.error == inf:
        orbit = Orbit(state, period_halves, error)
        begin_probe(probe, scene, period_halves)
        _, complete = march_with_jacobian(state, period_halves, probe, notes.log, notes.monodromy)
        if not stays_closed(notes.ring, look.half, period_halves, tolerance * look.scale):
            return no_orbit(state)
    if complete and spectral_radius(notes.monodromy, look.size) > 1.0 + _REPELS:
        return no_orbit(state)
    return orbit


@kernel
def orbit_multiplier(monodromy: NDArray[np.float64], size: int, period_halves: int) -> float:
    """Largest modulus of the Floquet multipliers over one period of the response.

    The map of an odd number of mirrored half cycles covers half a period, so the multipliers are squared.
    """
    radius = spectral_radius(monodromy, size)
    return radius * radius if period_halves % 2 == 1 else radius
